/* Each step begins where the one before ended, and none passes the stop time.

The next point is compared with the last one that the host gave, plus its step: what a host errs by in adding steps up
does not accumulate here. */
#include "identity.h"
#include "instance.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

static const double step_tolerance = 1e-6; /* relative; a host that subtracts times at t = 1e5 s errs by 1e-11 s */
static const double rounding = 16.0 * DBL_EPSILON; /* relative to the time; one of ns made by division errs by 1 */
static const double resolution = 1e9;              /* 1/s: where steps are equal, they are whole numbers of ns */

/* Write why a step of this length is refused, and return 0. */
static int wrong_length(double step, double fixed, const char *set_by, char *reason)
{
    char first[NUMBER_SIZE], second[NUMBER_SIZE];

    if (fixed > 0.0)
        snprintf(reason, REASON_SIZE, "a step of %s s is not accepted; the step is %s s%s%s", number_text(step, first),
                 number_text(fixed, second), set_by ? ", set by " : "", set_by ? set_by : "");
    else
        snprintf(reason, REASON_SIZE, "a step of %s s is not accepted; a step is > 0 s and finite",
                 number_text(step, first));
    return 0;
}

static int check_step(const Instance *instance, double time, double step, double fixed, const char *set_by,
                      char *reason)
{
    const double present = instance->present;
    const double tolerance = step_tolerance * step + rounding * fabs(present);
    char first[NUMBER_SIZE], second[NUMBER_SIZE];

    if (fixed > 0.0 ? !(fabs(step - fixed) <= step_tolerance * fixed) : !(step > 0.0 && step < DBL_MAX))
        return wrong_length(step, fixed, set_by, reason);
    if (!(fabs(time - present) <= tolerance)) {
        snprintf(reason, REASON_SIZE, "a step begins at the present communication point, %s s",
                 number_text(present, first));
        return 0;
    }
    if (instance->ends && time + step > instance->stop + tolerance) {
        snprintf(reason, REASON_SIZE, "a step to %s s passes the stop time %s s", number_text(time + step, first),
                 number_text(instance->stop, second));
        return 0;
    }
    return 1;
}

int admit_step(Instance *instance, double time, double step, double *length, char reason[REASON_SIZE])
{
    char text[NUMBER_SIZE];
    double rounded;

    *length = step;
    if (instance->fixed_step > 0.0 || !this_fmu.equal_steps) {
        if (instance->fixed_step > 0.0)
            *length = instance->fixed_step;
        return check_step(instance, time, step, instance->fixed_step, this_fmu.step_set_by, reason);
    }
    if (!check_step(instance, time, step, instance->length, "the first step", reason))
        return 0;
    if (instance->length == 0.0) {
        rounded = step < 1e6 ? rint(step * resolution) / resolution : step; /* a host errs in the last digits */
        if (!(rounded > 0.0)) {
            snprintf(reason, REASON_SIZE, "a step of %s s is not accepted; the shortest is 1e-9 s",
                     number_text(step, text));
            return 0;
        }
        if (component_first_step(&instance->component, rounded)) {
            snprintf(reason, REASON_SIZE, "%s", instance->component.message);
            return 0;
        }
        instance->length = rounded;
    }
    *length = instance->length;
    return 1;
}
