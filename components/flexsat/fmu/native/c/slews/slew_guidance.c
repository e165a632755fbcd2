#include "slew_guidance.h"

#include <math.h>
#include <string.h>

#include "allocation.h"
#include "linear_algebra.h"

#define PI 3.14159265358979323846

double profile_end(const Profile *profile)
{
    return profile->start + 2.0 * profile->ramp + profile->coast;
}

/* The least wheel torques (n, 3), squared over the weights (n), of a body torque; returns 1 if there are none. */
static int allocate(const double *axes, const double *weight, double *allocation)
{
    double weighted[WHEELS * 3], square[9] = {0.0}, inverse[9];
    int i, j, k;

    for (k = 0; k < WHEELS; k++)
        for (i = 0; i < 3; i++) {
            weighted[3 * k + i] = axes[3 * k + i] * weight[k];
            for (j = 0; j < 3; j++)
                square[3 * j + i] += axes[3 * k + j] * weighted[3 * k + i];
        }
    if (invert(3, square, inverse))
        return 1;
    times_matrix(WHEELS, 3, 3, weighted, inverse, allocation);
    for (k = 0; k < 3 * WHEELS; k++)
        allocation[k] = -allocation[k];
    return 0;
}

/* What is left of the momentum in both directions. The regulator drives offsets that need no net momentum back to
zero: both ends of that are provided for. */
static int find_room(Component *component, const double *axes, const double *momentum, const double *offset,
                     double *rise, double *fall)
{
    double ones[WHEELS], equal[WHEELS * 3], net[3] = {0.0, 0.0, 0.0}, kept[WHEELS];
    int i, k;

    for (k = 0; k < WHEELS; k++)
        ones[k] = 1.0;
    if (allocate(axes, ones, equal))
        return refuse(component, "the wheels cannot turn the body about all axes");
    for (k = 0; k < WHEELS; k++)
        for (i = 0; i < 3; i++)
            net[i] += axes[3 * k + i] * offset[k];
    times_vector(WHEELS, 3, equal, net, kept);
    for (k = 0; k < WHEELS; k++) {
        rise[k] = momentum[k] - fmax(offset[k], -kept[k]);
        fall[k] = momentum[k] + fmin(offset[k], -kept[k]);
        if (fmin(rise[k], fall[k]) <= 0.0)
            return refuse(component,
                          "wheel.speed_offset: wheel %d has %.4g N.m.s at rest, of %.4g N.m.s that a slew may use; "
                          "set the offset lower, or slew.authority or wheel.speed_band higher",
                          k + 1, momentum[k] - fmin(rise[k], fall[k]), momentum[k]);
    }
    return 0;
}

/* Divide by the largest. */
static void scale_weights(double *weight)
{
    double most = 1e-300;
    int k;

    for (k = 0; k < WHEELS; k++)
        most = fmax(most, weight[k]);
    for (k = 0; k < WHEELS; k++)
        weight[k] /= most;
}

int slew_wheels(Component *component, const double *axes, const double *torque, const double *momentum,
                const double *offset, int by_peak, SlewWheels *wheels)
{
    double rise[WHEELS], fall[WHEELS], weight[MOST_ALLOCATIONS][WHEELS];
    int k, alike = 1;

    if (find_room(component, axes, momentum, offset, rise, fall))
        return 1;
    for (k = 0; k < WHEELS; k++) {
        weight[0][k] = torque[k] > 0.0 ? fmin(rise[k], fall[k]) : 0.0;
        weight[1][k] = torque[k];
        wheels->per_torque[k] = torque[k] > 0.0 ? 1.0 / torque[k] : 0.0;
        wheels->per_rise[k] = 1.0 / rise[k];
        wheels->per_fall[k] = 1.0 / fall[k];
    }
    scale_weights(weight[0]);
    scale_weights(weight[1]);
    for (k = 0; k < WHEELS; k++) {
        weight[2][k] = sqrt(weight[0][k] * weight[1][k]);
        alike &= weight[0][k] == weight[1][k];
    }
    wheels->count = alike ? 1 : MOST_ALLOCATIONS;
    wheels->by_peak = by_peak;
    memcpy(wheels->axes, axes, sizeof wheels->axes);
    memcpy(wheels->limits, weight, sizeof wheels->limits);
    for (k = 0; k < wheels->count; k++)
        if (allocate(axes, weight[k], wheels->allocation[k]))
            return refuse(component, "wheel.torque_limit_factor: the wheels that have torque cannot turn the body "
                                     "about all axes");
    return 0;
}

void share_torque(const SlewWheels *wheels, int division, const double torque[3], double *shares)
{
    if (wheels->by_peak)
        least_peak(wheels->axes, wheels->limits[division], torque, shares);
    else
        times_vector(WHEELS, 3, wheels->allocation[division], torque, shares);
}

void limits_about(const SlewWheels *wheels, const double needed[3], double accelerations[MOST_ALLOCATIONS],
                  double rates[MOST_ALLOCATIONS])
{
    int one, k;

    for (one = 0; one < wheels->count; one++) {
        double torque = 0.0, momentum = 0.0, shares[WHEELS];
        share_torque(wheels, one, needed, shares);
        for (k = 0; k < WHEELS; k++) {
            const double share = shares[k];
            torque = fmax(torque, fabs(share) * wheels->per_torque[k]);
            momentum = fmax(momentum, fmax(share * wheels->per_rise[k], -share * wheels->per_fall[k]));
        }
        accelerations[one] = 1.0 / torque;
        rates[one] = 1.0 / momentum;
    }
}

double axis_of(const double rotation[3], double axis[3])
{
    const double angle = hypot(hypot(rotation[0], rotation[1]), rotation[2]);
    int k;

    for (k = 0; k < 3; k++)
        axis[k] = angle > 0.0 ? rotation[k] / angle : (k == 0 ? 1.0 : 0.0);
    return angle;
}

void plan_trapezium(const double axis[3], double angle, double start, double acceleration, double rate,
                    Profile *profile)
{
    memset(profile, 0, sizeof *profile);
    memcpy(profile->axis, axis, sizeof profile->axis);
    profile->start = start;
    if (angle == 0.0)
        return;
    rate = fmin(rate, sqrt(angle * acceleration)); /* a short turn never reaches the speed limit */
    profile->angle = angle;
    profile->ramp = rate / acceleration;
    profile->coast_rate = rate;
    profile->coast = angle / rate - profile->ramp;
}

double turn_duration(double angle, double acceleration, double rate)
{
    const double peak = fmin(rate, sqrt(angle * acceleration));

    return angle / (peak > 0.0 ? peak : 1.0) + peak / acceleration;
}

double remaining_duration(double angle, double acceleration, double rate, double initial)
{
    const double half = 0.5 * (initial * initial);
    const double peak = fmin(fmax(rate, initial), sqrt(angle * acceleration + half));
    const double coast = (angle - (peak * peak - half) / acceleration) / peak;

    return (2.0 * peak - initial) / acceleration + fmax(0.0, coast);
}

void shaper_for_pole(double frequency, double damping_ratio, double period, Shaper *shaper)
{
    const double damped = frequency * sqrt(1.0 - damping_ratio * damping_ratio);
    const double steps = floor(0.5 * PI / (damped * period)) + 1.0;
    const double spacing = steps * period;
    const double decay = exp(-damping_ratio * frequency * spacing);
    const double weights[3] = {1.0, -2.0 * decay * cos(damped * spacing), decay * decay};
    const double sum = weights[0] + weights[1] + weights[2];
    int k;

    for (k = 0; k < 3; k++) {
        shaper->weights[k] = weights[k] / sum;
        shaper->shifts[k] = (1 - k) * spacing;
    }
}
