/* Directional derivatives of real outputs with respect to real inputs, at the present communication point.

The state is held, so that only outputs that follow inputs have one that is not 0. What a step would make of inputs is
no derivative of FMI. */
#include "instance.h"

#include <float.h>
#include <math.h>
#include <string.h>

Status begin_to_differentiate(Instance *instance, const char *call)
{
    if (check_order(instance, DIFFERENTIATE, call) != CALL_OK)
        return CALL_ERROR;
    memset(instance->seed, 0, (size_t)port_table.counts[REAL] * sizeof(double));
    return instance->phase == INITIALIZING ? start_model(instance, call) : CALL_OK;
}

Status add_seed(Instance *instance, const char *call, int place, double value, size_t number)
{
    char text[NUMBER_SIZE];

    if (!(fabs(value) <= DBL_MAX))
        return refuse_call(instance, call, "seed %lu must be finite, got %s", (unsigned long)number,
                           number_text(value, text));
    instance->seed[place] += value;
    return CALL_OK;
}

Status differentiate(Instance *instance, const char *call)
{
    memset(instance->change, 0, (size_t)port_table.counts[REAL] * sizeof(double));
    if (port_table.differentiate(&instance->component, instance->seed, instance->change))
        return refuse_for_model(instance, call);
    return CALL_OK;
}

Status check_derivative(Instance *instance, const char *call, int place)
{
    char name[REASON_SIZE], text[NUMBER_SIZE];

    if (fabs(instance->change[place]) <= DBL_MAX)
        return CALL_OK;
    return refuse_call(instance, call, "the derivative of %s is %s: the seeds are too large",
                       variable_name(port_at(REAL, place), place, name), number_text(instance->change[place], text));
}
