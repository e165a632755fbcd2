#include "prepared_controller.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"
#include "zero_order_hold.h"

/* Arrange a matrix (rows, 4 n) for force a, force b, torque a, torque b as one for sines and cosines. */
static void fill_jitter(const double *a, const ControllerParameters *parameters, double *folded, Panels *panels)
{
    const double *force = parameters->imbalance_force, *torque = parameters->imbalance_torque;
    double *row = folded;
    int i, k;

    for (i = 0; i < panels->rows; i++, a += 4 * WHEELS, row += 2 * WHEELS)
        for (k = 0; k < WHEELS; k++) {
            row[k] = force[k] * a[k] + torque[k] * a[3 * WHEELS + k];
            row[WHEELS + k] = force[k] * a[WHEELS + k] - torque[k] * a[2 * WHEELS + k];
        }
    panels_fill(folded, panels);
}

/* Input matrices over a period for an input that changes after `part`: before, after; (s, n) each. */
static int split_hold(Memory *memory, const ControllerData *matrices, double period, double part, double *early,
                      double *late)
{
    double *rest = memory_doubles(memory, STATES * STATES), *a_part = memory_doubles(memory, STATES * STATES);
    double *b_part = memory_doubles(memory, STATES * WHEELS);

    if (memory->failed ||
        zero_order_hold(memory, STATES, WHEELS, matrices->a, matrices->b_torque, period - part, rest, late))
        return 1;
    memset(early, 0, STATES * WHEELS * sizeof(double));
    if (part == 0.0)
        return 0;
    if (zero_order_hold(memory, STATES, WHEELS, matrices->a, matrices->b_torque, part, a_part, b_part))
        return 1;
    times_matrix(STATES, STATES, WHEELS, rest, b_part, early);
    return 0;
}

/* ahead (s, width) += block (s, n) at a column */
static void add_block(double *ahead, size_t width, size_t column, const double *block)
{
    int i, k;

    for (i = 0; i < STATES; i++)
        for (k = 0; k < WHEELS; k++)
            ahead[(size_t)i * width + column + (size_t)k] += block[i * WHEELS + k];
}

/* Prepare the prediction to the time at which the torque acts: each whole period, with the torques then at work. */
static int prepare_ahead(Memory *memory, const ControllerData *matrices, const double *a, const double *early,
                         const double *late, double part, PreparedController *prepared)
{
    const int inputs = prepared->ahead_history.columns, width = STATES + inputs;
    const size_t count = (size_t)STATES * (size_t)width;
    double *ahead = memory_doubles(memory, count), *next = memory_doubles(memory, count);
    double *a_part = memory_doubles(memory, STATES * STATES), *b_part = memory_doubles(memory, STATES * WHEELS);
    int i, k;

    if (memory->failed)
        return 1;
    for (i = 0; i < STATES; i++)
        ahead[(size_t)i * (size_t)width + (size_t)i] = 1.0;
    for (k = prepared->whole_delay; k > 0; k--) {
        times_matrix(STATES, STATES, width, a, ahead, next);
        add_block(next, (size_t)width, (size_t)(STATES + (k - 1) * WHEELS), late);
        add_block(next, (size_t)width, (size_t)(STATES + k * WHEELS), early);
        memcpy(ahead, next, count * sizeof(double));
    }
    if (part > 0.0) {
        if (zero_order_hold(memory, STATES, WHEELS, matrices->a, matrices->b_torque, part, a_part, b_part))
            return 1;
        times_matrix(STATES, STATES, width, a_part, ahead, next);
        add_block(next, (size_t)width, STATES, b_part);
        memcpy(ahead, next, count * sizeof(double));
    }
    for (i = 0; i < CONTROLLED; i++) {
        const double *row = ahead + (size_t)i * (size_t)width;
        memcpy(next + (size_t)i * STATES, row, STATES * sizeof(double));
    }
    panels_fill(next, &prepared->ahead);
    for (i = 0; i < CONTROLLED; i++) {
        const double *row = ahead + (size_t)i * (size_t)width + STATES;
        memcpy(next + (size_t)i * (size_t)inputs, row, (size_t)inputs * sizeof(double));
    }
    panels_fill(next, &prepared->ahead_history);
    return 0;
}

/* Sample the model of the estimator, and the known delays. */
static int prepare_prediction(Memory *memory, const ControllerData *matrices, double part,
                              PreparedController *prepared)
{
    double *a = memory_doubles(memory, STATES * STATES), *b_jitter = memory_doubles(memory, STATES * 4 * WHEELS);
    double *early = memory_doubles(memory, STATES * WHEELS), *late = memory_doubles(memory, STATES * WHEELS);
    double *folded = memory_doubles(memory, STATES * 2 * WHEELS);

    if (memory->failed ||
        zero_order_hold(memory, STATES, 4 * WHEELS, matrices->a, matrices->b_jitter, prepared->period, a, b_jitter) ||
        split_hold(memory, matrices, prepared->period, part, early, late))
        return 1;
    panels_fill(a, &prepared->predict);
    panels_fill(late, &prepared->predict_late);
    panels_fill(early, &prepared->predict_early);
    fill_jitter(b_jitter, &prepared->parameters, folded, &prepared->predict_jitter);
    fill_jitter(matrices->jitter_torque, &prepared->parameters, folded, &prepared->jitter_torque);
    return prepared->delayed && prepare_ahead(memory, matrices, a, early, late, part, prepared);
}

static int prepare_reference(Memory *memory, const ControllerData *matrices, PreparedController *prepared)
{
    double *a = memory_doubles(memory, CONTROLLED * CONTROLLED), *b = memory_doubles(memory, CONTROLLED * WHEELS);

    if (memory->failed || zero_order_hold(memory, CONTROLLED, WHEELS, matrices->reference_a, matrices->reference_b,
                                          prepared->period, a, b))
        return 1;
    panels_fill(a, &prepared->reference_a);
    panels_fill(b, &prepared->reference_b);
    return 0;
}

static int any(size_t count, const double *values)
{
    size_t e;

    for (e = 0; e < count; e++)
        if (values[e] != 0.0)
            return 1;
    return 0;
}

/* Take memory for what is kept. */
static int take(Memory *memory, PreparedController *prepared)
{
    const int inputs = (prepared->whole_delay + 2) * WHEELS;
    int phase;

    prepared->gain = memory_take(memory, (size_t)prepared->phases, sizeof *prepared->gain);
    for (phase = 0; phase < prepared->phases && !memory->failed; phase++)
        panels_take(memory, STATES, MEASURED, &prepared->gain[phase]);
    panels_take(memory, MEASURED, STATES, &prepared->c);
    panels_take(memory, WHEELS, CONTROLLED, &prepared->feedback);
    panels_take(memory, WHEELS, 2 * WHEELS, &prepared->jitter_torque);
    panels_take(memory, STATES, STATES, &prepared->predict);
    panels_take(memory, STATES, WHEELS, &prepared->predict_late);
    panels_take(memory, STATES, WHEELS, &prepared->predict_early);
    panels_take(memory, STATES, 2 * WHEELS, &prepared->predict_jitter);
    panels_take(memory, CONTROLLED, CONTROLLED, &prepared->reference_a);
    panels_take(memory, CONTROLLED, WHEELS, &prepared->reference_b);
    if (prepared->delayed) {
        panels_take(memory, CONTROLLED, STATES, &prepared->ahead);
        panels_take(memory, CONTROLLED, inputs, &prepared->ahead_history);
    }
    if (prepared->estimates_slow)
        slow_errors_take(memory, &prepared->slow);
    if (prepared->optimal)
        prepared->optimum = optimum_take(memory);
    prepared->keep_out = prepared->parameters.keep_out;
    if (prepared->keep_out.active)
        prepared->keep_out.search = memory_take(memory, 1, sizeof *prepared->keep_out.search);
    return memory->failed;
}

/* Arrange the gains, and sample the models. */
static int sample(Memory *memory, const ControllerData *matrices, double part, PreparedController *prepared)
{
    MemoryBlock *mark = memory->last;
    const double *gain = prepared->parameters.fine_sensor ? matrices->gain_fine : matrices->gain_coarse;
    int phase;

    for (phase = 0; phase < prepared->phases; phase++)
        panels_fill(gain + (size_t)phase * STATES * MEASURED, &prepared->gain[phase]);
    panels_fill(matrices->c, &prepared->c);
    panels_fill(matrices->feedback, &prepared->feedback);
    if (prepare_prediction(memory, matrices, part, prepared) || prepare_reference(memory, matrices, prepared))
        return 1;
    if (prepared->estimates_slow &&
        slow_errors_prepare(memory, matrices, &prepared->parameters, prepared->slew_wheels.allocation[0], part,
                            &prepared->slow))
        return 1;
    memory_rewind(memory, mark);
    return 0;
}

/* What each wheel may give to a slew. */
static int prepare_wheels(Component *component, const ControllerData *matrices, PreparedController *prepared)
{
    const ControllerParameters *parameters = &prepared->parameters;
    double torque[WHEELS], momentum[WHEELS], offset[WHEELS];
    int k;

    for (k = 0; k < WHEELS; k++) {
        torque[k] = parameters->authority * parameters->torque_limits[k];
        momentum[k] = parameters->authority * matrices->wheel_inertia[k] * parameters->speed_bands[k];
        offset[k] = matrices->wheel_inertia[k] * parameters->speed_offset[k];
    }
    return slew_wheels(component, matrices->wheel_axis, torque, momentum, offset, parameters->least_peak,
                       &prepared->slew_wheels);
}

int prepare_controller(Component *component, const ControllerData *matrices, const ControllerParameters *parameters,
                       PreparedController *prepared)
{
    Memory *memory = &component->memory;
    const double period = matrices->period;
    /* a torque commanded at t acts from t + delay on, seen from the time of the measurement */
    const double delay = parameters->measurement_delay + parameters->actuation_delay;
    const double whole = floor(delay / period + 1e-6);
    double part = delay - whole * period;

    if (part < 1e-9)
        part = 0.0;
    prepared->parameters = *parameters;
    prepared->sines = quickest_sines();
    prepared->period = period;
    prepared->phases = parameters->fine_sensor ? matrices->gain_fine_rows : matrices->gain_coarse_rows;
    prepared->whole_delay = (int)whole;
    prepared->first_measurement = (int64_t)fmax(0.0, ceil(parameters->measurement_delay / period - 1e-6));
    prepared->delayed = delay > 0.0;
    prepared->smoothed = parameters->smoothed || parameters->guidance == SMOOTHED;
    prepared->cancels_jitter =
        parameters->feed_forward_jitter && any(WHEELS * 4 * WHEELS, matrices->jitter_torque);
    prepared->estimates_slow = estimates_slow_errors(parameters);
    prepared->optimal = parameters->guidance == QUADRATIC_PROGRAMME;
    prepared->knots = BRAKED + (prepared->optimal ? 2 * OPTIMUM_KNOTS : 4);
    memcpy(prepared->wheel_inertia, matrices->wheel_inertia, sizeof prepared->wheel_inertia);
    memcpy(prepared->inertia, matrices->inertia, sizeof prepared->inertia);
    memcpy(prepared->nominal_speed, matrices->nominal_speed, sizeof prepared->nominal_speed);
    if (prepare_wheels(component, matrices, prepared))
        return 1;
    if (parameters->null_rate > 0.0)
        prepare_null_motion(matrices, parameters, &prepared->null_motion);
    shaper_for_pole(matrices->shaper_frequency, matrices->shaper_damping, period, &prepared->shaper);
    return take(memory, prepared) || sample(memory, matrices, part, prepared);
}
