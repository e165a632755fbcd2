#include "off_loading.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"

#define WHOLE (1.0 - 1e-9)
#define SPANNED 1e-6
#define PURE 1e-9
#define SMALL 1e-9

static double clipped(double value, double most) { return fmin(fmax(value, -most), most); }

/* Whether the thrusts for a torque about an axis give it, and nothing else. */
static int is_pure(const PreparedThrusters *thrusters, const PreparedOffLoading *prepared, int axis, double sign)
{
    int i, k;

    for (i = 0; i < 6; i++) {
        double made = i == 3 + axis ? -sign : 0.0;
        for (k = 0; k < THRUSTERS; k++)
            made += thrusters->wrench[i][k] * fmax(sign * prepared->shares[k][axis], 0.0);
        if (!(fabs(made) < PURE))
            return 0;
    }
    return 1;
}

/* Thrust of each thruster for a torque about each axis; 1 if there is none. */
static int find_shares(const PreparedThrusters *thrusters, PreparedOffLoading *prepared)
{
    double gram[9], inverse[9], determinant;
    int i, j, k;

    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) {
            gram[3 * i + j] = 0.0;
            for (k = 0; k < THRUSTERS; k++)
                gram[3 * i + j] += thrusters->wrench[3 + i][k] * thrusters->wrench[3 + j][k];
        }
    determinant = gram[0] * (gram[4] * gram[8] - gram[5] * gram[7]) - gram[1] * (gram[3] * gram[8] - gram[5] * gram[6])
                  + gram[2] * (gram[3] * gram[7] - gram[4] * gram[6]);
    if (!(determinant > SPANNED) || invert(3, gram, inverse))
        return 1;
    for (k = 0; k < THRUSTERS; k++)
        for (i = 0; i < 3; i++) {
            double share = 0.0;
            for (j = 0; j < 3; j++)
                share += 2.0 * thrusters->wrench[3 + j][k] * inverse[3 * j + i];
            prepared->shares[k][i] = fabs(share) < SMALL ? 0.0 : share;
        }
    for (i = 0; i < 3; i++)
        if (!is_pure(thrusters, prepared, i, 1.0) || !is_pure(thrusters, prepared, i, -1.0))
            return 1;
    return 0;
}

int prepare_off_loading(Component *component, const PreparedThrusters *thrusters, PreparedOffLoading *prepared)
{
    const double *real = component->real;
    int i, k;

    if (find_shares(thrusters, prepared))
        return refuse(component, "thruster.position and thruster.direction give no torque about each axis without a "
                                 "force or another torque; let each thruster have an opposite one");
    for (i = 0; i < 3; i++) {
        prepared->most_share[i] = 0.0;
        prepared->least_share[i] = INFINITY;
        for (k = 0; k < THRUSTERS; k++) {
            const double size = fabs(prepared->shares[k][i]);
            prepared->most_share[i] = fmax(prepared->most_share[i], size);
            if (size > 0.0)
                prepared->least_share[i] = fmin(prepared->least_share[i], size);
        }
    }
    prepared->most_thrust = thrusters->most_thrust;
    prepared->minimum_impulse = thrusters->minimum_impulse;
    prepared->period = thrusters->period;
    prepared->duration = real[PORT_OFF_LOADING_DURATION];
    prepared->last = 0.1 * prepared->duration;
    prepared->tolerance = real[PORT_OFF_LOADING_TOLERANCE];
    return 0;
}

void begin_off_loading(const PreparedOffLoading *prepared, OffLoadingState *state, double time)
{
    state->until = time + prepared->duration;
    memset(state->owed, 0, sizeof state->owed);
}

int off_loading_is_done(const PreparedOffLoading *prepared, const OffLoadingState *state, double time,
                        const double momentum[3])
{
    const double most = fmax(fabs(momentum[0]), fmax(fabs(momentum[1]), fabs(momentum[2])));

    return (most < prepared->tolerance && time >= state->until) || time >= state->until + prepared->duration;
}

void plan_off_loading(const PreparedOffLoading *prepared, OffLoadingState *state, double time,
                      const double momentum[3])
{
    const double left = fmax(state->until - time, prepared->last);
    double fired[3];
    int i, k;

    for (i = 0; i < 3; i++) {
        const double most = prepared->most_thrust / prepared->most_share[i];
        state->owed[i] += prepared->period * clipped(-momentum[i] / left, most);
        fired[i] = 0.0;
        if (fabs(state->owed[i]) * prepared->least_share[i] >= WHOLE * prepared->minimum_impulse)
            fired[i] = clipped(state->owed[i], most * prepared->period);
        state->owed[i] -= fired[i];
    }
    for (k = 0; k < THRUSTERS; k++) {
        double thrust = 0.0;
        for (i = 0; i < 3; i++)
            thrust += fmax(prepared->shares[k][i] * fired[i], 0.0);
        state->command[k] = fmin(thrust / prepared->period, prepared->most_thrust);
    }
}

void stop_off_loading(OffLoadingState *state) { memset(state->command, 0, sizeof state->command); }
