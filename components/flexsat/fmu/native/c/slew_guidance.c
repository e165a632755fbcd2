#include "slew_guidance.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"

#define PI 3.14159265358979323846

double rotation_angle(const double rotation[3])
{
    return hypot(hypot(rotation[0], rotation[1]), rotation[2]);
}

double profile_end(const Profile *profile)
{
    return profile->start + 2.0 * profile->ramp + profile->coast;
}

void plan_profile(const double rotation[3], double start, const double inertia[9], const double torque[3],
                  const double momentum[3], Profile *profile)
{
    const double angle = rotation_angle(rotation);
    double acceleration, rate, short_rate;
    int k;

    memset(profile, 0, sizeof *profile);
    profile->axis[0] = 1.0;
    profile->start = start;
    if (angle == 0.0)
        return;
    for (k = 0; k < 3; k++)
        profile->axis[k] = rotation[k] / angle;
    capability_about(profile->axis, inertia, torque, momentum, &acceleration, &rate);
    short_rate = sqrt(angle * acceleration); /* a short turn never reaches the speed limit */
    if (short_rate < rate)
        rate = short_rate;
    profile->angle = angle;
    profile->ramp = rate / acceleration;
    profile->coast_rate = rate;
    profile->coast = angle / rate - profile->ramp;
}

void capability_about(const double axis[3], const double inertia[9], const double torque[3], const double momentum[3],
                      double *acceleration, double *rate)
{
    double needed[3], of_torque = 0.0, of_momentum = 0.0;
    int k;

    times_vector(3, 3, inertia, axis, needed);
    for (k = 0; k < 3; k++) {
        of_torque = fmax(of_torque, fabs(needed[k]) / torque[k]);
        of_momentum = fmax(of_momentum, fabs(needed[k]) / momentum[k]);
    }
    *acceleration = 1.0 / of_torque;
    *rate = 1.0 / of_momentum;
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
