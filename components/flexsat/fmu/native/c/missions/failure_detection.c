#include "failure_detection.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"

#define SPANNED 1e-6

void detect_failures(const PreparedDetection *prepared, DetectionState *state, int first, const double *torque,
                     const double *speed)
{
    int k;

    for (k = 0; k < WHEELS; k++) {
        const double inertia = prepared->wheel_inertia[k];
        double change;
        if (first)
            state->expected[k] = speed[k];
        state->expected[k] += prepared->step * torque[k] / inertia;
        state->residual[k] = speed[k] - state->expected[k];
        if (state->status[k] == WORKS) /* what it has lost until it is found to have failed counts */
            state->answered[k] = state->expected[k];
        state->expected[k] += prepared->follow * state->residual[k];
        state->beyond[k] = fabs(state->residual[k]) > prepared->threshold ? state->beyond[k] + 1 : 0;
        if (prepared->enabled && state->beyond[k] >= prepared->persistence && state->status[k] == WORKS)
            state->status[k] = OFF;
        if (state->status[k] != WORKS)
            state->status[k] = fabs(speed[k]) < prepared->seized_speed ? SEIZED : OFF;
        change = speed[k] - state->answered[k];
        if (state->status[k] == WORKS || !(fabs(change) > prepared->threshold))
            change = 0.0; /* noise, not a torque */
        state->given[k] = inertia * change / prepared->braking_time;
        state->answered[k] += prepared->step / prepared->braking_time * change;
    }
}

int inverse_of_axes(const double *axis, const int64_t *status, double inverse[3][3])
{
    double gram[9] = {0.0}, found[9], determinant;
    int i, j, k;

    for (k = 0; k < WHEELS; k++)
        if (status[k] == WORKS)
            for (i = 0; i < 3; i++)
                for (j = 0; j < 3; j++)
                    gram[3 * i + j] += axis[3 * k + i] * axis[3 * k + j];
    determinant = gram[0] * (gram[4] * gram[8] - gram[5] * gram[7]) - gram[1] * (gram[3] * gram[8] - gram[5] * gram[6])
                  + gram[2] * (gram[3] * gram[7] - gram[4] * gram[6]);
    memset(inverse, 0, 9 * sizeof(double));
    if (!(determinant > SPANNED) || invert(3, gram, found))
        return 1;
    memcpy(inverse, found, sizeof found);
    return 0;
}
