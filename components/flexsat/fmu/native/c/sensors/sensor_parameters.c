#include "sensor_parameters.h"

#include "number_text.h"
#include "periods.h"
#include "ports.h"

#define SHORTEST_STEP 1e-6 /* s, of the range of periods in quantities.py */

static int check_noise(Component *component, const char *name, double value)
{
    char text[NUMBER_SIZE];

    if (!(value >= 0.0))
        return refuse(component, "%s must be >= 0, got %s", name, number_text(value, text));
    return 0;
}

static int check(Component *component, const SensorParameters *parameters)
{
    char text[NUMBER_SIZE];

    if (component->integer[PORT_SEED] < 0)
        return refuse(component, "seed must be >= 0, got %d", component->integer[PORT_SEED]);
    if (check_noise(component, "gyro_noise", parameters->gyro_noise) ||
        check_noise(component, "accelerometer_noise", parameters->accelerometer_noise) ||
        check_noise(component, "encoder_noise", parameters->encoder_noise) ||
        check_noise(component, "star_tracker_noise", parameters->star_tracker_noise))
        return 1;
    if (!(parameters->filter_frequency > 0.0))
        return refuse(component, "filter_frequency must be > 0 Hz, got %s",
                      number_text(parameters->filter_frequency, text));
    if (parameters->star_tracker_steps % parameters->fast_steps)
        return refuse(component,
                      "star_tracker.period = %g s must be a whole multiple of fast_period = %g s: a sample is "
                      "flagged until the next one of the gyros, and one in between would be missed by a controller "
                      "that reads as often as these are taken",
                      (double)parameters->star_tracker_steps * parameters->step,
                      (double)parameters->fast_steps * parameters->step);
    return 0;
}

int sensor_parameters(Component *component, double step, SensorParameters *parameters)
{
    const double *real = component->real;
    const int *boolean = component->boolean;
    const double given = real[PORT_STEP_SIZE], fast = real[PORT_FAST_PERIOD], slow = real[PORT_STAR_TRACKER_PERIOD];
    const char *known = "the step of";
    char text[NUMBER_SIZE];
    int k;

    if (given > 0.0 && given < SHORTEST_STEP)
        return refuse(component, "step_size must be 0 for that of the first step, or >= %g s, got %s", SHORTEST_STEP,
                      number_text(given, text));
    if (!(step > 0.0))
        step = given;
    if (!(step > 0.0)) {
        step = fast;
        known = "fast_period =";
    }
    parameters->gyro_noise = real[PORT_GYRO_NOISE];
    parameters->accelerometer_noise = real[PORT_ACCELEROMETER_NOISE];
    parameters->accelerometer_noise_is_gyros = boolean[PORT_AS_PUBLISHED];
    parameters->encoder_noise = real[PORT_ENCODER_NOISE];
    parameters->star_tracker_noise =
        real[boolean[PORT_STAR_TRACKER_FINE] ? PORT_STAR_TRACKER_NOISE_FINE : PORT_STAR_TRACKER_NOISE_COARSE];
    parameters->filter_frequency = real[PORT_ACCELEROMETER_FILTER_FREQUENCY];
    parameters->step = step;
    parameters->fast_steps = whole_multiple(fast, step);
    if (parameters->fast_steps == 0)
        return refuse(component, "fast_period = %g s must be a whole multiple of the step of %g s", fast, step);
    parameters->star_tracker_steps = whole_multiple(slow, step);
    if (parameters->star_tracker_steps == 0)
        return refuse(component, "star_tracker.period = %g s must be a whole multiple of %s %g s", slow, known, step);
    parameters->jitter = boolean[PORT_JITTER_ENABLED];
    for (k = 0; k < WHEELS; k++) {
        parameters->imbalance_force[k] =
            real[PORT_JITTER_IMBALANCE_FORCE] * real[PORT_JITTER_IMBALANCE_FORCE_FACTOR + k];
        parameters->imbalance_torque[k] =
            real[PORT_JITTER_IMBALANCE_TORQUE] * real[PORT_JITTER_IMBALANCE_TORQUE_FACTOR + k];
        parameters->broadband_force[k] =
            real[PORT_JITTER_BROADBAND_FORCE] * real[PORT_JITTER_BROADBAND_FORCE_FACTOR + k];
        parameters->broadband_torque[k] =
            real[PORT_JITTER_BROADBAND_TORQUE] * real[PORT_JITTER_BROADBAND_TORQUE_FACTOR + k];
    }
    return check(component, parameters);
}
