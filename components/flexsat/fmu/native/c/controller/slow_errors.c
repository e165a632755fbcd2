#include "slow_errors.h"

#include <string.h>

#include "linear_algebra.h"
#include "rotations.h"
#include "zero_order_hold.h"

enum { FILTERED = 6 + SLOW, SAMPLED = GYROS + 3 };

int estimates_slow_errors(const ControllerParameters *parameters)
{
    return parameters->estimates_torque || parameters->estimates_bias;
}

int slow_errors_take(Memory *memory, SlowErrors *slow)
{
    panels_take(memory, STATES, TORQUES, &slow->enters);
    panels_take(memory, CONTROLLED, TORQUES, &slow->ahead);
    panels_take(memory, WHEELS, TORQUES, &slow->against);
    return memory->failed;
}

/* Wheels against a torque on the body bend the structure where they stand on it: the regulator's torque for that
deflection is added. */
static void fill_against(const ControllerData *matrices, const double *allocation, double *bent, double *against,
                         SlowErrors *slow)
{
    int i, k, j;

    times_matrix(MODES, WHEELS, TORQUES, matrices->deflection_of_torque, allocation, bent);
    for (i = 0; i < WHEELS; i++)
        for (j = 0; j < TORQUES; j++) {
            const double *feedback = matrices->feedback + (size_t)i * CONTROLLED + 3;
            double sum = 0.0;
            for (k = 0; k < MODES; k++)
                sum -= feedback[k] * bent[k * TORQUES + j];
            against[i * TORQUES + j] = sum - allocation[i * TORQUES + j];
        }
    panels_fill(against, &slow->against);
}

static void prepare_motion(const ControllerData *matrices, double part, SlowErrors *slow)
{
    double inertia[9];
    int i, k;

    memcpy(inertia, matrices->inertia, sizeof inertia);
    (void)invert(3, inertia, slow->mobility);
    for (i = 0; i < TORQUES; i++)
        for (k = 0; k < WHEELS; k++) {
            slow->late[i * WHEELS + k] = (part / slow->period - 1.0) * matrices->wheel_axis[k * 3 + i];
            slow->early[i * WHEELS + k] = -part / slow->period * matrices->wheel_axis[k * 3 + i];
        }
}

int slow_errors_prepare(Memory *memory, const ControllerData *matrices, const ControllerParameters *parameters,
                        const double *allocation, double part, SlowErrors *slow)
{
    const int fine = parameters->fine_sensor;
    const int chosen = parameters->estimates_bias + (parameters->estimates_torque && parameters->estimates_bias);
    const double delay = parameters->measurement_delay + parameters->actuation_delay;
    double *a = memory_doubles(memory, STATES * STATES), *b = memory_doubles(memory, STATES * TORQUES);
    double *bent = memory_doubles(memory, MODES * TORQUES), *against = memory_doubles(memory, WHEELS * TORQUES);

    if (memory->failed ||
        zero_order_hold(memory, STATES, TORQUES, matrices->a, matrices->b_body, matrices->period, a, b))
        return 1;
    slow->period = matrices->period;
    slow->phases = fine ? matrices->gain_fine_rows : matrices->gain_coarse_rows;
    slow->gyro_axis = matrices->gyro_axis;
    slow->sample = (fine ? matrices->slow_sample_fine : matrices->slow_sample_coarse) + chosen * FILTERED * SAMPLED;
    slow->between = (fine ? matrices->slow_between_fine : matrices->slow_between_coarse) + chosen * FILTERED * GYROS;
    prepare_motion(matrices, part, slow);
    panels_fill(b, &slow->enters);
    memset(b, 0, STATES * TORQUES * sizeof(double));
    if (delay > 0.0 && zero_order_hold(memory, STATES, TORQUES, matrices->a, matrices->b_body, delay, a, b))
        return 1;
    panels_fill(b, &slow->ahead);
    fill_against(matrices, allocation, bent, against, slow);
    return 0;
}

void add_times_torque(const Panels *matrix, const SlowState *state, Real *y)
{
    const Real torque[TORQUES] = {(Real)state->errors[0], (Real)state->errors[1], (Real)state->errors[2]};

    panels_add_times(matrix, torque, y);
}

void slow_errors_predict(const SlowErrors *slow, const Real *late, const Real *early, SlowState *state)
{
    double torque[TORQUES], change[3], turn[3];
    int i, k;

    for (i = 0; i < TORQUES; i++) {
        torque[i] = state->errors[i];
        for (k = 0; k < WHEELS; k++)
            torque[i] += slow->late[i * WHEELS + k] * late[k] + slow->early[i * WHEELS + k] * early[k];
    }
    times_vector(3, 3, slow->mobility, torque, change);
    for (k = 0; k < 3; k++) {
        change[k] *= slow->period;
        turn[k] = slow->period * (state->rate[k] + 0.5 * change[k]);
        state->rate[k] += change[k];
    }
    rotate_quaternion(state->attitude, turn, state->attitude);
}

void slow_errors_correct(const SlowErrors *slow, const Real *gyro_rate, const double *seen, int64_t steps,
                         SlowState *state)
{
    double innovation[SAMPLED], change[FILTERED], off[3];
    int k;

    if (seen != NULL && steps > slow->phases) {
        memcpy(state->attitude, seen, sizeof state->attitude);
        return;
    }
    for (k = 0; k < GYROS; k++) {
        const double *axis = slow->gyro_axis + (size_t)k * 3;
        innovation[k] = gyro_rate[k] - (axis[0] * state->rate[0] + axis[1] * state->rate[1] + axis[2] * state->rate[2])
                        - state->errors[TORQUES + k];
    }
    if (seen == NULL) {
        times_vector(FILTERED, GYROS, slow->between, innovation, change);
        if (steps >= slow->phases)
            memset(change + 6, 0, SLOW * sizeof(double));
    } else {
        relative_mrp(seen, state->attitude, off);
        for (k = 0; k < 3; k++)
            innovation[GYROS + k] = 4.0 * off[k];
        times_vector(FILTERED, SAMPLED, slow->sample, innovation, change);
    }
    rotate_quaternion(state->attitude, change, state->attitude);
    for (k = 0; k < 3; k++)
        state->rate[k] += change[3 + k];
    for (k = 0; k < SLOW; k++)
        state->errors[k] += change[6 + k];
}
