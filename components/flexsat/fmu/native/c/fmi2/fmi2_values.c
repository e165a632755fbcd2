/* Values of variables, set and read by lists of value references. A list is examined before any of it is written. */
#include "instance.h"

#include <stdio.h>
#include <string.h>

static const char *const kind_names[KINDS] = {"real", "integer", "boolean", "string"};
static const unsigned first_reference[KINDS] = {0, REAL_COUNT, REAL_COUNT + INTEGER_COUNT,
                                                REAL_COUNT + INTEGER_COUNT + BOOLEAN_COUNT};
static const unsigned counts[KINDS] = {REAL_COUNT, INTEGER_COUNT, BOOLEAN_COUNT, STRING_COUNT};

/* Refuse a reference that no variable of the kind has. */
static fmi2Status refuse_reference(Instance *instance, const char *call, Kind kind, fmi2ValueReference reference)
{
    const Port *port;
    char name[REASON_SIZE], reason[REASON_SIZE];

    if (reference < VARIABLE_COUNT) {
        port = &ports[port_of_reference[reference]];
        variable_name(port, (int)(reference - first_reference[port->kind]), name);
        snprintf(reason, sizeof reason, "it is that of %.500s, which is %s", name, kind_names[port->kind]);
    } else if (counts[kind] > 0)
        snprintf(reason, sizeof reason, "there are %u, from %u on", counts[kind], first_reference[kind]);
    else
        strcpy(reason, "there are none");
    return refuse_call(instance, call, "%s value reference %u: no such variable; %s", kind_names[kind], reference,
                       reason);
}

/* Refuse lists that are NULL, and wrong references; `flags` become those of all variables in the list. */
static fmi2Status examine(Instance *instance, const char *call, Kind kind, const fmi2ValueReference vr[], size_t n,
                          const void *values, int *flags)
{
    const fmi2ValueReference first = first_reference[kind];
    size_t k;

    *flags = 0;
    if (instance == NULL)
        return fmi2Error;
    if (n > 0 && vr == NULL)
        return refuse_call(instance, call, "%lu value references in a NULL array", (unsigned long)n);
    if (n > 0 && values == NULL)
        return refuse_call(instance, call, "%lu values in a NULL array", (unsigned long)n);
    for (k = 0; k < n; k++) {
        const fmi2ValueReference place = vr[k] - first; /* of a smaller reference it is beyond all */
        if (place >= counts[kind])
            return refuse_reference(instance, call, kind, vr[k]);
        *flags |= ports[port_of_reference[vr[k]]].flags;
    }
    return fmi2OK;
}

/* Prepare to read: examine the list, and compute what has to be computed first. */
static fmi2Status begin_to_read(Instance *instance, const char *call, Kind kind, const fmi2ValueReference vr[],
                                size_t n, const void *values)
{
    int flags;

    if (examine(instance, call, kind, vr, n, values, &flags) != fmi2OK || check_order(instance, GET, call) != fmi2OK)
        return fmi2Error;
    if (instance->phase == INITIALIZING && flags & OUTPUT && start_model(instance, call) != fmi2OK)
        return fmi2Error;
    if (flags & (ON_DEMAND | FOLLOWS_INPUTS) && instance->phase != FAILED && instance->started)
        return compute_outputs(instance, call, flags);
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[])
{
    Instance *instance = c;
    size_t k;

    if (begin_to_read(instance, "getReal", REAL, vr, n, values) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        values[k] = instance->component.real[vr[k] - first_reference[REAL]];
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer values[])
{
    Instance *instance = c;
    size_t k;

    if (begin_to_read(instance, "getInteger", INTEGER, vr, n, values) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        values[k] = instance->component.integer[vr[k] - first_reference[INTEGER]];
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean values[])
{
    Instance *instance = c;
    size_t k;

    if (begin_to_read(instance, "getBoolean", BOOLEAN, vr, n, values) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        values[k] = instance->component.boolean[vr[k] - first_reference[BOOLEAN]];
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String values[])
{
    Instance *instance = c;
    size_t k;

    if (begin_to_read(instance, "getString", STRING, vr, n, values) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        values[k] = instance->component.string[vr[k] - first_reference[STRING]];
    return fmi2OK;
}

/* Prepare to write: examine the list, and refuse outputs, and parameters that are fixed now. `got` is the text of the
first value. */
static fmi2Status begin_to_write(Instance *instance, const char *call, Kind kind, const fmi2ValueReference vr[],
                                 size_t n, const void *values, int *flags)
{
    if (examine(instance, call, kind, vr, n, values, flags) != fmi2OK)
        return fmi2Error;
    return check_order(instance, SET, call);
}

/* Return whether a variable may be set now at all; a refusal needs the text of the value. */
static int may_be_set(const Instance *instance, const Port *port)
{
    return !(port->flags & OUTPUT)
           && !(port->flags & PARAMETER && instance->phase == STEPPING && !(port->flags & TUNABLE));
}

static fmi2Status refuse_variable(Instance *instance, const char *call, const Port *port, fmi2ValueReference reference,
                                  const char *value)
{
    char name[REASON_SIZE];

    variable_name(port, (int)(reference - first_reference[port->kind]), name);
    if (port->flags & OUTPUT)
        return refuse_call(instance, call, "%s is an output and cannot be set", name);
    return refuse_call(instance, call, "%s is a fixed parameter and cannot be set after initialisation, got %s", name,
                       value);
}

static fmi2Status refuse_value(Instance *instance, const char *call, const Port *port, fmi2ValueReference reference,
                               const char *why)
{
    char name[REASON_SIZE];

    variable_name(port, (int)(reference - first_reference[port->kind]), name);
    return refuse_call(instance, call, "%s %s", name, why);
}

/* Note what values were written, with these flags among them. */
static fmi2Status finish_writing(Instance *instance, const char *call, size_t n, int flags)
{
    if (n == 0)
        return fmi2OK;
    instance->inputs_set = 1;
    if (instance->phase != STEPPING) {
        if (flags & STARTS)
            instance->started = 0;
        return fmi2OK;
    }
    if (FEEDS_ON_DEMAND)
        instance->stale = 1;
    if (flags & TUNABLE && component_tuned(&instance->component))
        return refuse_for_model(instance, call);
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[])
{
    static const char call[] = "setReal";
    Instance *instance = c;
    char text[REASON_SIZE], number[NUMBER_SIZE];
    int flags;
    size_t k;

    if (begin_to_write(instance, call, REAL, vr, n, values, &flags) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++) {
        const Port *port = &ports[port_of_reference[vr[k]]];
        if (!may_be_set(instance, port))
            return refuse_variable(instance, call, port, vr[k], number_text(values[k], number));
        if (!acceptable(port, values[k], text))
            return refuse_value(instance, call, port, vr[k], text);
    }
    for (k = 0; k < n; k++)
        instance->component.real[vr[k] - first_reference[REAL]] = values[k];
    return finish_writing(instance, call, n, flags);
}

fmi2Status FMI2(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer values[])
{
    static const char call[] = "setInteger";
    Instance *instance = c;
    char text[REASON_SIZE];
    int flags;
    size_t k;

    if (begin_to_write(instance, call, INTEGER, vr, n, values, &flags) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++) {
        const Port *port = &ports[port_of_reference[vr[k]]];
        snprintf(text, sizeof text, "%d", values[k]);
        if (!may_be_set(instance, port))
            return refuse_variable(instance, call, port, vr[k], text);
        if (!acceptable(port, values[k], text))
            return refuse_value(instance, call, port, vr[k], text);
    }
    for (k = 0; k < n; k++)
        instance->component.integer[vr[k] - first_reference[INTEGER]] = values[k];
    return finish_writing(instance, call, n, flags);
}

fmi2Status FMI2(fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean values[])
{
    static const char call[] = "setBoolean";
    Instance *instance = c;
    int flags;
    size_t k;

    if (begin_to_write(instance, call, BOOLEAN, vr, n, values, &flags) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++) {
        const Port *port = &ports[port_of_reference[vr[k]]];
        if (!may_be_set(instance, port))
            return refuse_variable(instance, call, port, vr[k], values[k] ? "True" : "False");
    }
    for (k = 0; k < n; k++)
        instance->component.boolean[vr[k] - first_reference[BOOLEAN]] = values[k] != 0;
    return finish_writing(instance, call, n, flags);
}

fmi2Status FMI2(fmi2SetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String values[])
{
    static const char call[] = "setString";
    Instance *instance = c;
    char text[REASON_SIZE];
    int flags;
    size_t k;

    if (begin_to_write(instance, call, STRING, vr, n, values, &flags) != fmi2OK)
        return fmi2Error;
    for (k = 0; k < n; k++) {
        const Port *port = &ports[port_of_reference[vr[k]]];
        if (values[k] == NULL)
            return refuse_call(instance, call, "value %lu is NULL", (unsigned long)k + 1);
        if (!is_utf8(values[k]))
            return refuse_call(instance, call, "value %lu is not UTF-8: %.200s", (unsigned long)k + 1, values[k]);
        snprintf(text, sizeof text, "'%.200s'", values[k]);
        if (!may_be_set(instance, port))
            return refuse_variable(instance, call, port, vr[k], text);
        if (strlen(values[k]) >= STRING_SIZE) {
            snprintf(text, sizeof text, "must have less than %d bytes, got %lu", STRING_SIZE,
                     (unsigned long)strlen(values[k]));
            return refuse_value(instance, call, port, vr[k], text);
        }
    }
    for (k = 0; k < n; k++)
        strcpy(instance->component.string[vr[k] - first_reference[STRING]], values[k]);
    return finish_writing(instance, call, n, flags);
}
