/* Rules for reading and writing values: what may be set when, what has to be computed first. */
#include "instance.h"

#include <stdio.h>
#include <string.h>

Status begin_to_read(Instance *instance, const char *call, int flags)
{
    if (check_order(instance, GET, call) != CALL_OK)
        return CALL_ERROR;
    if (instance->phase == INITIALIZING && flags & OUTPUT && start_model(instance, call) != CALL_OK)
        return CALL_ERROR;
    if (flags & (ON_DEMAND | FOLLOWS_INPUTS) && instance->phase != FAILED && instance->started)
        return compute_outputs(instance, call, flags);
    return CALL_OK;
}

/* Return whether a variable may be set now at all; a refusal needs the text of the value. */
static int may_be_set(const Instance *instance, const Port *port)
{
    return !(port->flags & OUTPUT)
           && !(port->flags & PARAMETER && instance->phase == STEPPING && !(port->flags & TUNABLE));
}

static Status refuse_variable(Instance *instance, const char *call, const Port *port, int place, const char *value)
{
    char name[REASON_SIZE];

    variable_name(port, place, name);
    if (port->flags & OUTPUT)
        return refuse_call(instance, call, "%s is an output and cannot be set", name);
    return refuse_call(instance, call, "%s is a fixed parameter and cannot be set after initialisation, got %s", name,
                       value);
}

static Status refuse_value(Instance *instance, const char *call, const Port *port, int place, const char *why)
{
    char name[REASON_SIZE];

    return refuse_call(instance, call, "%s %s", variable_name(port, place, name), why);
}

Status check_number(Instance *instance, const char *call, const Port *port, int place, double value)
{
    char text[REASON_SIZE];

    if (!may_be_set(instance, port)) {
        if (port->kind == INTEGER)
            snprintf(text, sizeof text, "%d", (int)value);
        else
            number_text(value, text);
        return refuse_variable(instance, call, port, place, text);
    }
    if (!acceptable(port, value, text))
        return refuse_value(instance, call, port, place, text);
    return CALL_OK;
}

/* Whether all values lie within the limits; not-a-number does not. */
static int within(const Port *port, size_t n, const double values[])
{
    const double least = port->least, greatest = port->greatest;
    int all = 1;
    size_t k;

    for (k = 0; k < n; k++)
        all &= (values[k] >= least) & (values[k] <= greatest);
    return all;
}

Status check_numbers(Instance *instance, const char *call, const Port *port, int place, size_t n,
                     const double values[])
{
    size_t k;

    if (may_be_set(instance, port) && within(port, n, values))
        return CALL_OK;
    for (k = 0; k < n; k++)
        if (check_number(instance, call, port, place + (int)k, values[k]) != CALL_OK)
            return CALL_ERROR;
    return CALL_OK;
}

Status check_boolean(Instance *instance, const char *call, const Port *port, int place, int value)
{
    if (!may_be_set(instance, port))
        return refuse_variable(instance, call, port, place, value ? "True" : "False");
    return CALL_OK;
}

Status check_text(Instance *instance, const char *call, const Port *port, int place, const char *value, size_t number)
{
    char text[REASON_SIZE];

    if (value == NULL)
        return refuse_call(instance, call, "value %lu is NULL", (unsigned long)number);
    if (!is_utf8(value))
        return refuse_call(instance, call, "value %lu is not UTF-8: %.200s", (unsigned long)number, value);
    if (!may_be_set(instance, port)) {
        snprintf(text, sizeof text, "'%.200s'", value);
        return refuse_variable(instance, call, port, place, text);
    }
    if (strlen(value) >= STRING_SIZE) {
        snprintf(text, sizeof text, "must have less than %d bytes, got %lu", STRING_SIZE,
                 (unsigned long)strlen(value));
        return refuse_value(instance, call, port, place, text);
    }
    return CALL_OK;
}

Status finish_writing(Instance *instance, const char *call, int flags)
{
    instance->inputs_set = 1;
    if (instance->phase != STEPPING) {
        if (flags & STARTS)
            instance->started = 0;
        return CALL_OK;
    }
    if (port_table.feeds_on_demand)
        instance->stale = 1;
    if (flags & TUNABLE && component_tuned(&instance->component))
        return refuse_for_model(instance, call);
    return CALL_OK;
}
