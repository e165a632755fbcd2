#include "controller_parameters.h"

#include <math.h>

#include "number_text.h"
#include "ports.h"

#define LONGEST_DELAY 0.02 /* s, of measurement and of actuation, each */

static const char *const guidances[] = {"bang-coast-bang", "smoothed", "qp"}; /* in the order of Guidance */
static const char *const during_slew[] = {"refuse", "replan"};

static int is_same(const char *text, const char *other)
{
    for (; *text != '\0' && *text == *other; text++)
        other++;
    return *text == *other;
}

static int choose_design(Component *component, const ControllerData **matrices)
{
    const char *chosen = component->string[PORT_DESIGN];
    const int published = is_same(chosen, "published");

    if (!published && !is_same(chosen, "robust"))
        return refuse(component, "design must be published or robust, got '%s'", chosen);
    if (component->boolean[PORT_AS_PUBLISHED] && !HAS_AS_PUBLISHED)
        return refuse(component, "as_published: this spacecraft has no published release; set it to false");
    *matrices = published ? &controller_published : &controller_corrected;
    if (component->boolean[PORT_AS_PUBLISHED])
        *matrices = &controller_as_published;
    return 0;
}

/* The place of a text among the known ones, or -1. */
static int place_of(const char *text, const char *const known[], int count)
{
    int k;

    for (k = 0; k < count; k++)
        if (is_same(text, known[k]))
            return k;
    return -1;
}

static int check_delay(Component *component, const char *name, double delay)
{
    char text[NUMBER_SIZE];

    if (delay >= 0.0 && delay <= LONGEST_DELAY && fabs(delay * 1e3 - rint(delay * 1e3)) <= 1e-6)
        return 0;
    return refuse(component, "%s must be whole milliseconds from 0 to %.3f s, got %s", name, LONGEST_DELAY,
                  number_text(delay, text));
}

static int check_limits(Component *component, const ControllerParameters *parameters)
{
    char text[NUMBER_SIZE];

    if (!(parameters->torque_limit > 0.0))
        return refuse(component, "wheel.torque_limit must be > 0, got %s",
                      number_text(parameters->torque_limit, text));
    if (!(parameters->speed_band > 0.0))
        return refuse(component, "wheel.speed_band must be > 0, got %s", number_text(parameters->speed_band, text));
    if (!(parameters->authority > 0.0 && parameters->authority <= 1.0))
        return refuse(component, "slew.authority must be in (0, 1], got %s",
                      number_text(parameters->authority, text));
    return 0;
}

/* The limits and imbalance of each wheel. A wheel whose torque is 0 has failed. */
static int read_wheels(Component *component, ControllerParameters *parameters)
{
    const double *torque = component->real + PORT_WHEEL_TORQUE_LIMIT_FACTOR;
    const double *band = component->real + PORT_WHEEL_SPEED_BAND_FACTOR;
    char text[NUMBER_SIZE];
    int k;

    for (k = 0; k < WHEELS; k++)
        if (!(torque[k] >= 0.0))
            return refuse(component, "wheel.torque_limit_factor[%d] must be >= 0, got %s", k + 1,
                          number_text(torque[k], text));
    for (k = 0; k < WHEELS; k++)
        if (!(band[k] > 0.0))
            return refuse(component, "wheel.speed_band_factor[%d] must be > 0, got %s", k + 1,
                          number_text(band[k], text));
    for (k = 0; k < WHEELS; k++) {
        parameters->torque_limits[k] = parameters->torque_limit * torque[k];
        parameters->speed_bands[k] = parameters->speed_band * band[k];
        parameters->speed_offset[k] = component->real[PORT_WHEEL_SPEED_OFFSET + k];
        parameters->imbalance_force[k] = component->real[PORT_JITTER_IMBALANCE_FORCE] *
                                         component->real[PORT_JITTER_IMBALANCE_FORCE_FACTOR + k];
        parameters->imbalance_torque[k] = component->real[PORT_JITTER_IMBALANCE_TORQUE] *
                                          component->real[PORT_JITTER_IMBALANCE_TORQUE_FACTOR + k];
    }
    return 0;
}

static int read_cones(Component *component, KeepOut *cones)
{
    const double *real = component->real;
    const double *const directions[CONES] = {real + PORT_KEEP_OUT_FIRST_DIRECTION,
                                             real + PORT_KEEP_OUT_SECOND_DIRECTION};
    const double half_angles[CONES] = {real[PORT_KEEP_OUT_FIRST_HALF_ANGLE],
                                       real[PORT_KEEP_OUT_SECOND_HALF_ANGLE]};

    return keep_out(component, real + PORT_KEEP_OUT_AXIS, directions, half_angles, cones);
}

static int choose_guidance(Component *component, ControllerParameters *parameters)
{
    const char *guidance = component->string[PORT_SLEW_GUIDANCE];
    const char *during = component->string[PORT_COMMAND_DURING_SLEW];
    const int planned = place_of(guidance, guidances, 3), replans = place_of(during, during_slew, 2);

    if (planned < 0)
        return refuse(component, "slew.guidance must be one of bang-coast-bang, smoothed, qp, got '%s'", guidance);
    if (replans < 0)
        return refuse(component, "command.during_slew must be one of refuse, replan, got '%s'", during);
    parameters->guidance = (Guidance)planned;
    parameters->replans = replans;
    return 0;
}

int controller_parameters(Component *component, const ControllerData **matrices, ControllerParameters *parameters)
{
    const double *real = component->real;
    const int *boolean = component->boolean;
    char text[NUMBER_SIZE];

    if (choose_design(component, matrices) || read_cones(component, &parameters->keep_out))
        return 1;
    parameters->fine_sensor = boolean[PORT_STAR_TRACKER_FINE];
    parameters->feed_forward_jitter = boolean[PORT_JITTER_FEED_FORWARD];
    parameters->smoothed = boolean[PORT_REFERENCE_SMOOTHED];
    parameters->open_loop = boolean[PORT_OPEN_LOOP];
    parameters->torque_limit = real[PORT_WHEEL_TORQUE_LIMIT];
    parameters->speed_band = real[PORT_WHEEL_SPEED_BAND];
    parameters->authority = real[PORT_SLEW_AUTHORITY];
    parameters->measurement_delay = real[PORT_DELAY_MEASUREMENT];
    parameters->actuation_delay = real[PORT_DELAY_ACTUATION];
    parameters->estimates_torque = boolean[PORT_FILTER_DISTURBANCE];
    parameters->estimates_bias = boolean[PORT_FILTER_GYRO_BIAS];
    parameters->null_rate = real[PORT_WHEEL_NULL_MOTION_RATE];
    parameters->capture_angle = real[PORT_INITIAL_CAPTURE_ANGLE];
    parameters->least_peak = boolean[PORT_SLEW_LEAST_PEAK];
    parameters->gyroscopic = boolean[PORT_SLEW_GYROSCOPIC];
    parameters->linear_attitude = boolean[PORT_AS_PUBLISHED];
    if (check_limits(component, parameters) || choose_guidance(component, parameters) ||
        read_wheels(component, parameters))
        return 1;
    if (parameters->linear_attitude && (parameters->estimates_torque || parameters->estimates_bias))
        return refuse(component, "filter.disturbance, filter.gyro_bias: as_published has no such filter; set both to "
                                 "false");
    if (parameters->linear_attitude && parameters->keep_out.active)
        return refuse(component,
                      "keep_out: as_published has attitudes as sums of a quarter of the angle, which hold near zero "
                      "only; set the half-angles to 0, or design = 'published' in place of as_published");
    if (parameters->gyroscopic && (parameters->smoothed || parameters->guidance == SMOOTHED))
        return refuse(component, "slew.gyroscopic: the smoothed reference has no wheel speeds that follow it; set "
                                 "slew.gyroscopic to false, or another guidance");
    if (!(parameters->capture_angle > 0.0))
        return refuse(component, "initial.capture_angle must be > 0, got %s",
                      number_text(parameters->capture_angle, text));
    return check_delay(component, "delay.measurement", parameters->measurement_delay) ||
           check_delay(component, "delay.actuation", parameters->actuation_delay);
}
