#include "slow_errors.h"

#include <string.h>

#include "linear_algebra.h"
#include "zero_order_hold.h"

int estimates_slow_errors(const ControllerParameters *parameters)
{
    return parameters->estimates_torque || parameters->estimates_bias;
}

int slow_errors_take(Memory *memory, SlowErrors *slow)
{
    panels_take(memory, SLOW, MEASURED, &slow->gain);
    panels_take(memory, STATES, SLOW, &slow->shift);
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

int slow_errors_prepare(Memory *memory, const ControllerData *matrices, const ControllerParameters *parameters,
                        const double *allocation, SlowErrors *slow)
{
    const int chosen = parameters->estimates_bias + (parameters->estimates_torque && parameters->estimates_bias);
    const double *gains = parameters->fine_sensor ? matrices->slow_gain_fine : matrices->slow_gain_coarse;
    const double delay = parameters->measurement_delay + parameters->actuation_delay;
    double *a = memory_doubles(memory, STATES * STATES), *b = memory_doubles(memory, STATES * TORQUES);
    double *bent = memory_doubles(memory, MODES * TORQUES), *against = memory_doubles(memory, WHEELS * TORQUES);

    if (memory->failed ||
        zero_order_hold(memory, STATES, TORQUES, matrices->a, matrices->b_body, matrices->period, a, b))
        return 1;
    panels_fill(gains + (size_t)chosen * SLOW * MEASURED, &slow->gain);
    panels_fill(parameters->fine_sensor ? matrices->slow_shift_fine : matrices->slow_shift_coarse, &slow->shift);
    panels_fill(b, &slow->enters);
    memset(b, 0, STATES * TORQUES * sizeof(double));
    if (delay > 0.0 && zero_order_hold(memory, STATES, TORQUES, matrices->a, matrices->b_body, delay, a, b))
        return 1;
    panels_fill(b, &slow->ahead);
    fill_against(matrices, allocation, bent, against, slow);
    return 0;
}

void slow_errors_predict(const SlowErrors *slow, const Real *errors, Real *estimate)
{
    panels_add_times(&slow->enters, errors, estimate);
}

void slow_errors_correct(const SlowErrors *slow, const Real *innovation, Real *errors, Real *estimate)
{
    Real change[SLOW];
    int k;

    memset(change, 0, sizeof change);
    panels_add_times(&slow->gain, innovation, change);
    for (k = 0; k < SLOW; k++)
        errors[k] += change[k];
    panels_add_times(&slow->shift, change, estimate);
}
