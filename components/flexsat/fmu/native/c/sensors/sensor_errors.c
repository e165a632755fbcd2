#include "sensor_errors.h"

#include <math.h>
#include <string.h>

#include "number_text.h"

static const char *const sources[BLINDING] = {"sun", "earth"};

static int check(Component *component, const char *name, double value)
{
    char text[NUMBER_SIZE];

    if (!(value >= 0.0))
        return refuse(component, "%s must be >= 0, got %s", name, number_text(value, text));
    return 0;
}

static double length_of(const double vector[3])
{
    return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

static void unit(const double vector[3], double found[3])
{
    const double length = length_of(vector);
    int k;

    for (k = 0; k < 3; k++)
        found[k] = length > 0.0 ? vector[k] / length : vector[k];
}

static int any(int count, const double *values)
{
    int k;

    for (k = 0; k < count; k++)
        if (values[k] != 0.0)
            return 1;
    return 0;
}

static void cross(const double a[3], const double b[3], double found[3])
{
    found[0] = a[1] * b[2] - a[2] * b[1];
    found[1] = a[2] * b[0] - a[0] * b[2];
    found[2] = a[0] * b[1] - a[1] * b[0];
}

static int read_sources(Component *component, SensorErrors *errors)
{
    const double *real = component->real;
    const double *const directions[BLINDING] = {real + PORT_STAR_TRACKER_SUN_DIRECTION,
                                                real + PORT_STAR_TRACKER_EARTH_DIRECTION};
    const double half_angles[BLINDING] = {real[PORT_STAR_TRACKER_SUN_HALF_ANGLE],
                                          real[PORT_STAR_TRACKER_EARTH_HALF_ANGLE]};
    int k;

    errors->blinds = 0;
    for (k = 0; k < BLINDING; k++) {
        if (half_angles[k] > 0.0 && !(length_of(directions[k]) > 0.0))
            return refuse(component, "star_tracker.%s.direction must have a direction, got zeros", sources[k]);
        unit(directions[k], errors->sources[k]);
        errors->cosines[k] = half_angles[k] > 0.0 ? cos(half_angles[k]) : 2.0;
        errors->blinds |= half_angles[k] > 0.0;
    }
    return 0;
}

int sensor_errors(Component *component, const SensorsData *matrices, SensorErrors *errors)
{
    const double *real = component->real;
    const double time = real[PORT_STAR_TRACKER_LOW_FREQUENCY_TIME];
    char text[NUMBER_SIZE];

    if (check(component, "gyro.bias_deviation", real[PORT_GYRO_BIAS_DEVIATION]) ||
        check(component, "gyro.bias_walk", real[PORT_GYRO_BIAS_WALK]) ||
        check(component, "gyro.scale_error_deviation", real[PORT_GYRO_SCALE_ERROR_DEVIATION]) ||
        check(component, "gyro.misalignment_deviation", real[PORT_GYRO_MISALIGNMENT_DEVIATION]) ||
        check(component, "accelerometer.bias_deviation", real[PORT_ACCELEROMETER_BIAS_DEVIATION]) ||
        check(component, "star_tracker.low_frequency_error", real[PORT_STAR_TRACKER_LOW_FREQUENCY_ERROR]) ||
        check(component, "star_tracker.roll_factor", real[PORT_STAR_TRACKER_ROLL_FACTOR]))
        return 1;
    if (!(time > 0.0))
        return refuse(component, "star_tracker.low_frequency_time must be > 0 s, got %s", number_text(time, text));
    if (!(length_of(real + PORT_STAR_TRACKER_BORESIGHT) > 0.0))
        return refuse(component, "star_tracker.boresight must have a direction, got zeros");
    if (read_sources(component, errors))
        return 1;
    errors->rate_of_gyros = matrices->rate_of_gyros;
    errors->walk = real[PORT_GYRO_BIAS_WALK] * sqrt(real[PORT_FAST_PERIOD]);
    errors->memory = exp(-real[PORT_STAR_TRACKER_PERIOD] / time);
    errors->renewal = real[PORT_STAR_TRACKER_LOW_FREQUENCY_ERROR] * sqrt(1.0 - errors->memory * errors->memory);
    unit(real + PORT_STAR_TRACKER_BORESIGHT, errors->boresight);
    errors->roll_factor = real[PORT_STAR_TRACKER_ROLL_FACTOR];
    memcpy(errors->misalignment, real + PORT_STAR_TRACKER_MISALIGNMENT, sizeof errors->misalignment);
    errors->walks = real[PORT_GYRO_BIAS_WALK] > 0.0;
    errors->of_gyros = any(GYROS, real + PORT_GYRO_BIAS) || any(GYROS, real + PORT_GYRO_SCALE_ERROR) ||
                       real[PORT_GYRO_BIAS_DEVIATION] > 0.0 || real[PORT_GYRO_SCALE_ERROR_DEVIATION] > 0.0 ||
                       real[PORT_GYRO_MISALIGNMENT_DEVIATION] > 0.0 || errors->walks ||
                       any(GYROS, real + PORT_GYRO_MOUNTING_ERROR_X) || any(GYROS, real + PORT_GYRO_MOUNTING_ERROR_Y) ||
                       any(GYROS, real + PORT_GYRO_MOUNTING_ERROR_Z);
    errors->drifts = real[PORT_STAR_TRACKER_LOW_FREQUENCY_ERROR] > 0.0;
    errors->rolls = errors->roll_factor != 1.0;
    return 0;
}

void sensor_errors_init(const Component *component, const SensorsData *matrices, ErrorState *state)
{
    const double *real = component->real;
    const double *const mounting[3] = {real + PORT_GYRO_MOUNTING_ERROR_X, real + PORT_GYRO_MOUNTING_ERROR_Y,
                                       real + PORT_GYRO_MOUNTING_ERROR_Z};
    double turned[3][GYROS];
    int i, k;

    for (k = 0; k < GYROS; k++)
        state->gyro_bias[k] = real[PORT_GYRO_BIAS + k] + real[PORT_GYRO_BIAS_DEVIATION] * random_normal(&state->random);
    for (k = 0; k < GYROS; k++)
        state->gyro_scale[k] = real[PORT_GYRO_SCALE_ERROR + k] +
                               real[PORT_GYRO_SCALE_ERROR_DEVIATION] * random_normal(&state->random);
    for (i = 0; i < 3; i++)
        for (k = 0; k < GYROS; k++)
            turned[i][k] =
                mounting[i][k] + real[PORT_GYRO_MISALIGNMENT_DEVIATION] * random_normal(&state->random);
    for (k = 0; k < GYROS; k++) {
        const double rotation[3] = {turned[0][k], turned[1][k], turned[2][k]};
        cross(rotation, matrices->gyro_axis + (size_t)k * 3, state->gyro_tilt[k]);
    }
    for (k = 0; k < ACCELEROMETERS; k++)
        state->accelerometer_bias[k] = real[PORT_ACCELEROMETER_BIAS + k] +
                                       real[PORT_ACCELEROMETER_BIAS_DEVIATION] * random_normal(&state->random);
    for (k = 0; k < 3; k++)
        state->low_frequency[k] = real[PORT_STAR_TRACKER_LOW_FREQUENCY_ERROR] * random_normal(&state->random);
}

void add_fast_errors(const SensorErrors *errors, int first, const double *rate, ErrorState *state, double *gyro_rate,
                     double *accelerometer)
{
    double body[3] = {0.0, 0.0, 0.0};
    int i, k;

    if (errors->walks && !first)
        for (k = 0; k < GYROS; k++)
            state->gyro_bias[k] += errors->walk * random_normal(&state->random);
    if (errors->of_gyros) {
        for (i = 0; i < 3; i++)
            for (k = 0; k < GYROS; k++)
                body[i] += errors->rate_of_gyros[i * GYROS + k] * rate[k];
        for (k = 0; k < GYROS; k++) {
            const double *tilt = state->gyro_tilt[k];
            gyro_rate[k] += state->gyro_bias[k] + state->gyro_scale[k] * rate[k] +
                            (tilt[0] * body[0] + tilt[1] * body[1] + tilt[2] * body[2]);
        }
    }
    for (k = 0; k < ACCELEROMETERS; k++)
        accelerometer[k] += state->accelerometer_bias[k];
}

void add_star_tracker_errors(const SensorErrors *errors, int first, ErrorState *state, double error[3])
{
    const double *axis = errors->boresight;
    int k;

    if (errors->drifts && !first)
        for (k = 0; k < 3; k++)
            state->low_frequency[k] =
                state->low_frequency[k] * errors->memory + errors->renewal * random_normal(&state->random);
    if (errors->rolls) {
        const double along = error[0] * axis[0] + error[1] * axis[1] + error[2] * axis[2];
        for (k = 0; k < 3; k++)
            error[k] += (errors->roll_factor - 1.0) * along * axis[k];
    }
    for (k = 0; k < 3; k++)
        error[k] = error[k] + state->low_frequency[k] + errors->misalignment[k];
}

int is_blinded(const SensorErrors *errors, const double body_from_inertial[4])
{
    const double scalar = body_from_inertial[3];
    double twice[3], again[3], seen[3];
    int k;

    if (!errors->blinds)
        return 0;
    cross(body_from_inertial, errors->boresight, twice);
    for (k = 0; k < 3; k++)
        twice[k] *= 2.0;
    cross(body_from_inertial, twice, again);
    for (k = 0; k < 3; k++)
        seen[k] = errors->boresight[k] + scalar * twice[k] + again[k];
    for (k = 0; k < BLINDING; k++) {
        const double *source = errors->sources[k];
        if (source[0] * seen[0] + source[1] * seen[1] + source[2] * seen[2] >= errors->cosines[k])
            return 1;
    }
    return 0;
}
