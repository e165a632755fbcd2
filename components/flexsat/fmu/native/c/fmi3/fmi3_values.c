/* Values of variables as FMI 3.0 has them: a value reference is that of a port with all its elements, or of the time.
Lists are examined before any of them is written. */
#include "fmi3_instance.h"

#include <stdio.h>
#include <string.h>

static const char *const type_names[KINDS] = {"Float64", "Int32", "Boolean", "String"};

const Port *port_of(fmi3ValueReference reference)
{
    if (reference == TIME_REFERENCE || reference > (fmi3ValueReference)port_table.ports)
        return NULL;
    return &ports[reference - 1];
}

Status refuse_reference(Instance *instance, const char *call, const char *type, fmi3ValueReference reference)
{
    const Port *port = port_of(reference);
    char reason[REASON_SIZE];

    if (reference == TIME_REFERENCE)
        strcpy(reason, "it is that of the time, which is Float64");
    else if (port != NULL)
        snprintf(reason, sizeof reason, "it is that of %.500s, which is %s", port->name, type_names[port->kind]);
    else
        snprintf(reason, sizeof reason, "there are %d of all types, from %d on", port_table.ports + 1,
                 TIME_REFERENCE);
    return refuse_call(instance, call, "%s value reference %u: no such variable; %s", type, (unsigned)reference,
                       reason);
}

/* Refuse lists that are NULL, wrong references, and a wrong number of values; `flags` become those of all ports. */
static Status examine(Instance *instance, const char *call, Kind kind, const fmi3ValueReference vr[], size_t n,
                      const void *values, size_t size, int *flags)
{
    size_t scalars = 0, k;

    *flags = 0;
    if (instance == NULL)
        return CALL_ERROR;
    if (n > 0 && vr == NULL)
        return refuse_call(instance, call, "%lu value references in a NULL array", (unsigned long)n);
    for (k = 0; k < n; k++) {
        const Port *port = port_of(vr[k]);
        if (port != NULL && port->kind == kind) {
            *flags |= port->flags;
            scalars += (size_t)port->size;
        } else if (kind == REAL && vr[k] == TIME_REFERENCE)
            scalars++;
        else
            return refuse_reference(instance, call, type_names[kind], vr[k]);
    }
    if (size != scalars)
        return refuse_call(instance, call, "%lu values, where the variables have %lu elements", (unsigned long)size,
                           (unsigned long)scalars);
    if (size > 0 && values == NULL)
        return refuse_call(instance, call, "%lu values in a NULL array", (unsigned long)size);
    return CALL_OK;
}

/* Examine a list that is to be read, and compute what has to be computed first. */
static Status examine_to_read(Instance *instance, const char *call, Kind kind, const fmi3ValueReference vr[],
                              size_t n, const void *values, size_t size)
{
    int flags;

    if (examine(instance, call, kind, vr, n, values, size, &flags) != CALL_OK)
        return CALL_ERROR;
    if (flags & OUTPUT && instance->phase == INSTANTIATED) /* there are start values only */
        return refuse_call(instance, call, "outputs are not read before fmi3EnterInitializationMode");
    return begin_to_read(instance, call, flags);
}

/* Examine a list that is to be written; the values are examined later. */
static Status examine_to_write(Instance *instance, const char *call, Kind kind, const fmi3ValueReference vr[],
                               size_t n, const void *values, size_t size, int *flags)
{
    size_t k;

    if (examine(instance, call, kind, vr, n, values, size, flags) != CALL_OK)
        return CALL_ERROR;
    for (k = 0; k < n; k++)
        if (vr[k] == TIME_REFERENCE)
            return refuse_call(instance, call, "the time is the independent variable and cannot be set");
    return check_order(instance, SET, call);
}

static fmi3Status finish(Instance *instance, const char *call, size_t n, int flags)
{
    return n == 0 ? fmi3OK : (fmi3Status)finish_writing(instance, call, flags);
}

fmi3Status FMI3(fmi3GetFloat64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[],
                                size_t size)
{
    const Instance *instance = c;
    size_t k;

    if (examine_to_read(c, "getFloat64", REAL, vr, n, values, size) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++) {
        const Port *port = port_of(vr[k]);
        if (port == NULL)
            *values++ = instance->present;
        else {
            memcpy(values, instance->component.real + port->first, (size_t)port->size * sizeof *values);
            values += port->size;
        }
    }
    return fmi3OK;
}

fmi3Status FMI3(fmi3GetInt32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int32 values[],
                              size_t size)
{
    const Instance *instance = c;
    size_t k;
    int i;

    if (examine_to_read(c, "getInt32", INTEGER, vr, n, values, size) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            *values++ = instance->component.integer[port_of(vr[k])->first + i];
    return fmi3OK;
}

fmi3Status FMI3(fmi3GetBoolean)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[],
                                size_t size)
{
    const Instance *instance = c;
    size_t k;
    int i;

    if (examine_to_read(c, "getBoolean", BOOLEAN, vr, n, values, size) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            *values++ = instance->component.boolean[port_of(vr[k])->first + i] != 0;
    return fmi3OK;
}

fmi3Status FMI3(fmi3GetString)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String values[],
                               size_t size)
{
    const Instance *instance = c;
    size_t k;
    int i;

    if (examine_to_read(c, "getString", STRING, vr, n, values, size) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            *values++ = instance->component.string[port_of(vr[k])->first + i];
    return fmi3OK;
}

fmi3Status FMI3(fmi3SetFloat64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                                size_t size)
{
    static const char call[] = "setFloat64";
    Instance *instance = c;
    const double *value = values;
    int flags;
    size_t k;

    if (examine_to_write(instance, call, REAL, vr, n, values, size, &flags) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++) {
        const Port *port = port_of(vr[k]);
        if (check_numbers(instance, call, port, port->first, (size_t)port->size, value) != CALL_OK)
            return fmi3Error;
        value += port->size;
    }
    for (k = 0; k < n; k++) {
        const Port *port = port_of(vr[k]);
        memcpy(instance->component.real + port->first, values, (size_t)port->size * sizeof *values);
        values += port->size;
    }
    return finish(instance, call, n, flags);
}

fmi3Status FMI3(fmi3SetInt32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 values[],
                              size_t size)
{
    static const char call[] = "setInt32";
    Instance *instance = c;
    const int32_t *value = values;
    int flags, i;
    size_t k;

    if (examine_to_write(instance, call, INTEGER, vr, n, values, size, &flags) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            if (check_number(instance, call, port_of(vr[k]), port_of(vr[k])->first + i, *value++) != CALL_OK)
                return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            instance->component.integer[port_of(vr[k])->first + i] = *values++;
    return finish(instance, call, n, flags);
}

fmi3Status FMI3(fmi3SetBoolean)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[],
                                size_t size)
{
    static const char call[] = "setBoolean";
    Instance *instance = c;
    const bool *value = values;
    int flags, i;
    size_t k;

    if (examine_to_write(instance, call, BOOLEAN, vr, n, values, size, &flags) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            if (check_boolean(instance, call, port_of(vr[k]), port_of(vr[k])->first + i, *value++) != CALL_OK)
                return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            instance->component.boolean[port_of(vr[k])->first + i] = *values++ ? 1 : 0;
    return finish(instance, call, n, flags);
}

fmi3Status FMI3(fmi3SetString)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String values[],
                               size_t size)
{
    static const char call[] = "setString";
    Instance *instance = c;
    const fmi3String *value = values;
    int flags, i;
    size_t k;

    if (examine_to_write(instance, call, STRING, vr, n, values, size, &flags) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++, value++)
            if (check_text(instance, call, port_of(vr[k]), port_of(vr[k])->first + i, *value,
                           (size_t)(value - values) + 1) != CALL_OK)
                return fmi3Error;
    for (k = 0; k < n; k++)
        for (i = 0; i < port_of(vr[k])->size; i++)
            strcpy(instance->component.string[port_of(vr[k])->first + i], *values++);
    return finish(instance, call, n, flags);
}
