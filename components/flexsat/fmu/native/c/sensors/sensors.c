/* Run-time sensors and wheel jitter: noise, anti-aliasing filter, sampling at their own rates. The twin of
runtime/sensors.py, which documents it, and of fmu/python/sensors.py. */
#include "sensors.h"

#include <math.h>
#include <string.h>

#include "data.h"
#include "rotations.h"
#include "zero_order_hold.h"

#define STREAM 2 /* a component's own random streams: plant and sensors may be given the same seed */
#define MOST_STEPS INT64_C(0x20000000000000)
#define PI 3.14159265358979323846

/* Sample the anti-aliasing filter, with its input taken as linear between steps. */
static int prepare(Component *component, PreparedSensors *prepared, double step)
{
    SensorParameters *parameters = &prepared->parameters;
    double chain[16] = {0.0}, sampled[16], integral[16], scratch[3 * 16];
    double corner, accelerometer_noise;
    int i, k;

    if (sensor_parameters(component, step, parameters))
        return 1;
    corner = 2.0 * PI * parameters->filter_frequency;
    /* states, input, input slope: the exponential of the chain gives the first-order hold exactly */
    chain[1] = corner * parameters->step;
    chain[4] = -corner * parameters->step;
    chain[5] = -sqrt(2.0) * corner * parameters->step;
    chain[6] = corner * parameters->step;
    chain[11] = 1.0 / parameters->step * parameters->step;
    transition_with(4, chain, 1.0, sampled, integral, scratch);
    for (i = 0; i < 2; i++) {
        double *row = prepared->transition[i];
        const double new = sampled[4 * i + 3];
        row[0] = sampled[4 * i];
        row[1] = sampled[4 * i + 1];
        row[2] = sampled[4 * i + 2] - new;
        row[3] = new;
    }
    accelerometer_noise = parameters->accelerometer_noise_is_gyros ? parameters->gyro_noise
                                                                   : parameters->accelerometer_noise;
    for (k = 0; k < GYROS; k++)
        prepared->deviation[k] = parameters->gyro_noise * component->real[PORT_GYRO_NOISE_FACTOR + k];
    for (k = 0; k < ACCELEROMETERS; k++)
        prepared->deviation[GYROS + k] = accelerometer_noise;
    for (k = 0; k < WHEELS; k++)
        prepared->deviation[GYROS + ACCELEROMETERS + k] = parameters->encoder_noise;
    for (k = 0; k < WHEELS; k++) {
        prepared->broadband_deviation[k] = prepared->broadband_deviation[WHEELS + k] = parameters->broadband_force[k];
        prepared->broadband_deviation[2 * WHEELS + k] = parameters->broadband_torque[k];
        prepared->broadband_deviation[3 * WHEELS + k] = parameters->broadband_torque[k];
    }
    return 0;
}

/* Begin all noise with the seed, which may change during a run. */
static void begin_noise(const Component *component, SensorState *state)
{
    const uint32_t seed = (uint32_t)component->integer[PORT_SEED];

    random_begin(&state->noise, seed, STREAM, 0);
    random_begin(&state->disturbance, seed, STREAM, 1);
    random_begin(&state->errors.random, seed, STREAM, 2);
}

/* The state before the first sample: instruments at rest, encoders at the nominal speeds. */
static void init(Component *component, SensorState *state, const SensorsData *matrices)
{
    const double *nominal_speed = matrices->nominal_speed;
    double *real = component->real;

    memset(state, 0, sizeof *state);
    begin_noise(component, state);
    sensor_errors_init(component, matrices, &state->errors);
    memset(real + PORT_STAR_TRACKER_QUATERNION, 0, 3 * sizeof(double));
    real[PORT_STAR_TRACKER_QUATERNION + 3] = 1.0;
    memset(real + PORT_STAR_TRACKER_MRP, 0, 3 * sizeof(double));
    component->boolean[PORT_STAR_TRACKER_VALID] = 0;
    memset(real + PORT_GYRO_RATE, 0, GYROS * sizeof(double));
    memset(real + PORT_ACCELEROMETER_ACCELERATION, 0, ACCELEROMETERS * sizeof(double));
    memcpy(real + PORT_ENCODER_SPEED, nominal_speed, WHEELS * sizeof(double));
    memset(real + PORT_ENCODER_ANGLE, 0, WHEELS * sizeof(double));
    memset(real + PORT_JITTER_FORCE_X, 0, WRENCHES * sizeof(double));
}

static void filter_acceleration(const PreparedSensors *prepared, SensorState *state, const double *acceleration)
{
    int k;

    for (k = 0; k < ACCELEROMETERS; k++) {
        const double output = state->filter[0][k], rate = state->filter[1][k], last = state->filter[2][k];
        const double now = acceleration[k];
        const double *first = prepared->transition[0], *second = prepared->transition[1];
        if (state->count > 0) { /* the filter starts at rest, with its first input as its last */
            state->filter[0][k] = first[0] * output + first[1] * rate + first[2] * last + first[3] * now;
            state->filter[1][k] = second[0] * output + second[1] * rate + second[2] * last + second[3] * now;
        }
        state->filter[2][k] = now;
    }
}

static void sample_fast(Component *component, const PreparedSensors *prepared, SensorState *state)
{
    double *real = component->real;
    const double *deviation = prepared->deviation;
    int k;

    for (k = 0; k < GYROS; k++)
        real[PORT_GYRO_RATE + k] = real[PORT_GYRO_SITE_RATE + k] + random_normal(&state->noise) * *deviation++;
    for (k = 0; k < ACCELEROMETERS; k++)
        real[PORT_ACCELEROMETER_ACCELERATION + k] =
            state->filter[0][k] + random_normal(&state->noise) * *deviation++;
    for (k = 0; k < WHEELS; k++) {
        real[PORT_ENCODER_SPEED + k] = real[PORT_WHEEL_SPEED + k] + random_normal(&state->noise) * *deviation++;
        real[PORT_ENCODER_ANGLE + k] = real[PORT_WHEEL_ANGLE + k];
    }
    add_fast_errors(&prepared->errors, state->count == 0, real + PORT_GYRO_SITE_RATE, &state->errors,
                    real + PORT_GYRO_RATE, real + PORT_ACCELEROMETER_ACCELERATION);
    component->boolean[PORT_STAR_TRACKER_VALID] = 0;
    if (prepared->parameters.jitter)
        for (k = 0; k < 4 * WHEELS; k++)
            state->broadband[k] = random_normal(&state->disturbance) * prepared->broadband_deviation[k];
}

static void sample_star_tracker(Component *component, const PreparedSensors *prepared, SensorState *state)
{
    double *seen = component->real + PORT_STAR_TRACKER_QUATERNION;
    double error[3], turned[4];
    int k;

    for (k = 0; k < 3; k++)
        error[k] = prepared->parameters.star_tracker_noise * random_normal(&state->noise);
    add_star_tracker_errors(&prepared->errors, state->count == 0, &state->errors, error);
    if (is_blinded(&prepared->errors, component->real + PORT_ATTITUDE_QUATERNION))
        return;
    component->boolean[PORT_STAR_TRACKER_VALID] = 1;
    quaternion_from_rotation_vector(error, turned);
    compose_quaternions(turned, component->real + PORT_ATTITUDE_QUATERNION, seen);
    mrp_from_quaternion(seen, component->real + PORT_STAR_TRACKER_MRP);
}

static void write_jitter(Component *component, const PreparedSensors *prepared, const SensorState *state)
{
    const SensorParameters *parameters = &prepared->parameters;
    double jitter[4 * WHEELS];
    int k;

    harmonic_jitter(prepared->sines, WHEELS, component->real + PORT_WHEEL_SPEED, component->real + PORT_WHEEL_ANGLE, parameters->step,
                    parameters->imbalance_force, parameters->imbalance_torque, jitter);
#ifdef PORT_JITTER_HARMONICS_FACTOR
    {
        double scratch[3 * WHEELS];
        add_harmonics(&prepared->harmonics, prepared->sines, WHEELS, component->real + PORT_WHEEL_SPEED,
                      component->real + PORT_WHEEL_ANGLE, parameters->step,
                      component->real + PORT_JITTER_HARMONICS_FACTOR, scratch, jitter);
    }
#endif
    for (k = 0; k < 4 * WHEELS; k++)
        jitter[k] += state->broadband[k];
    sparse_times(&prepared->wrench_of_jitter, jitter, component->real + PORT_JITTER_FORCE_X);
}

int component_start(Component *component)
{
    const SensorsData *matrices = component->boolean[PORT_AS_PUBLISHED] ? &sensors_as_published : &sensors_corrected;
    PreparedSensors *prepared = memory_take(&component->memory, 1, sizeof *prepared);
    SensorState *state = memory_take(&component->memory, 1, sizeof *state);

    if (component->boolean[PORT_AS_PUBLISHED] && !HAS_AS_PUBLISHED)
        return refuse(component, "as_published: this spacecraft has no published release; set it to false");
    if (component->memory.failed ||
        sparse_of(&component->memory, WRENCHES, 4 * WHEELS, matrices->wrench_of_jitter, &prepared->wrench_of_jitter))
        return refuse(component, "the host gives no memory");
    prepared->sines = quickest_sines();
    prepared->harmonics.count = matrices->harmonic_order_rows;
    prepared->harmonics.order = matrices->harmonic_order;
    prepared->harmonics.force = matrices->harmonic_force;
    prepared->harmonics.torque = matrices->harmonic_torque;
    prepared->harmonics.phase = matrices->harmonic_phase;
    component->own = prepared;
    component->state = (unsigned char *)state;
    component->state_size = sizeof *state;
    component->step_length = component->real[PORT_STEP_SIZE];
    if (prepare(component, prepared, 0.0) || sensor_errors(component, matrices, &prepared->errors))
        return 1;
    init(component, state, matrices);
    return 0;
}

/* Sample the filter for steps of this length. */
int component_first_step(Component *component, double length)
{
    if (prepare(component, component->own, length))
        return 1;
    component->step_length = length;
    return 0;
}

/* Sample the inputs now; the outputs hold from now on. */
int component_advance(Component *component, double time, double step)
{
    const PreparedSensors *prepared = component->own;
    SensorState *state = (SensorState *)(void *)component->state;

    (void)time;
    (void)step;
    filter_acceleration(prepared, state, component->real + PORT_ACCELEROMETER_SITE_ACCELERATION);
    if (state->count % prepared->parameters.fast_steps == 0)
        sample_fast(component, prepared, state);
    if (state->count % prepared->parameters.star_tracker_steps == 0)
        sample_star_tracker(component, prepared, state);
    if (prepared->parameters.jitter)
        write_jitter(component, prepared, state);
    state->count++;
    return 0;
}

int component_restored(Component *component)
{
    const SensorState *state = (const SensorState *)(const void *)component->state;

    if (state->count < 0 || state->count > MOST_STEPS)
        return refuse(component, "the saved state has a number of steps that no run reaches");
    return prepare(component, component->own, component->step_length);
}

/* The seed has changed. */
int component_tuned(Component *component)
{
    if (component->integer[PORT_SEED] < 0)
        return refuse(component, "seed must be >= 0, got %d", component->integer[PORT_SEED]);
    begin_noise(component, (SensorState *)(void *)component->state);
    return 0;
}

/* No output follows inputs or is computed on demand. */
int component_follow_inputs(Component *component)
{
    (void)component;
    return 0;
}

int component_evaluate(Component *component)
{
    (void)component;
    return 0;
}
