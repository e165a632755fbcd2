/* Values of variables as FMI 2.0 has them: set and read by lists of value references, each that of a scalar. A list is
examined before any of it is written. Most lists are runs of consecutive references, and are handled run by run. */
#include "fmi2_instance.h"

#include <stdio.h>
#include <string.h>

static const char *const kind_names[KINDS] = {"real", "integer", "boolean", "string"};

static fmi2ValueReference first_reference(Kind kind)
{
    int first = 0, k;

    for (k = 0; k < (int)kind; k++)
        first += port_table.counts[k];
    return (fmi2ValueReference)first;
}

static const Port *port_of(fmi2ValueReference reference) { return &ports[port_of_reference[reference]]; }

/* What `examine` finds of a list: the flags of all its variables, and the length of its first run. */
typedef struct List {
    int flags;
    size_t run;
} List;

enum { AT_ONCE = 8 };

/* How many references at the beginning of a list follow one on the other. */
static size_t run_of(const fmi2ValueReference vr[], size_t n)
{
    const fmi2ValueReference first = vr[0];
    size_t k = 0;

    while (k + AT_ONCE <= n) {
        fmi2ValueReference off = 0, i;
        for (i = 0; i < AT_ONCE; i++)
            off |= (vr[k + i] - i) ^ (first + (fmi2ValueReference)k);
        if (off)
            break;
        k += AT_ONCE;
    }
    while (k < n && vr[k] - first == k)
        k++;
    return k;
}

/* Refuse a reference that no variable of the kind has. */
static Status refuse_reference(Instance *instance, const char *call, Kind kind, fmi2ValueReference reference)
{
    const int count = port_table.counts[kind];
    const Port *port;
    char name[REASON_SIZE], reason[REASON_SIZE];

    if (reference < (fmi2ValueReference)port_table.variables) {
        port = &ports[port_of_reference[reference]];
        variable_name(port, (int)(reference - first_reference(port->kind)), name);
        snprintf(reason, sizeof reason, "it is that of %.500s, which is %s", name, kind_names[port->kind]);
    } else if (count > 0)
        snprintf(reason, sizeof reason, "there are %d, from %u on", count, first_reference(kind));
    else
        strcpy(reason, "there are none");
    return refuse_call(instance, call, "%s value reference %u: no such variable; %s", kind_names[kind], reference,
                       reason);
}

/* Refuse lists that are NULL, and wrong references; `list` becomes what is found. */
static Status examine(Instance *instance, const char *call, Kind kind, const fmi2ValueReference vr[], size_t n,
                      const void *values, List *list)
{
    const fmi2ValueReference first = first_reference(kind), count = (fmi2ValueReference)port_table.counts[kind];
    size_t k, run;

    list->flags = 0;
    if (instance == NULL)
        return CALL_ERROR;
    if (n > 0 && vr == NULL)
        return refuse_call(instance, call, "%lu value references in a NULL array", (unsigned long)n);
    if (n > 0 && values == NULL)
        return refuse_call(instance, call, "%lu values in a NULL array", (unsigned long)n);
    for (k = 0; k < n; k += run) {
        const fmi2ValueReference place = vr[k] - first; /* of a smaller reference it is beyond all */
        const Port *port, *last;
        run = run_of(vr + k, n - k);
        if (place >= count || run > count - place)
            return refuse_reference(instance, call, kind, place >= count ? vr[k] : first + count);
        for (port = port_of(vr[k]), last = port_of(vr[k + run - 1]); port <= last; port++)
            list->flags |= port->flags;
        if (k == 0)
            list->run = run;
    }
    return CALL_OK;
}

/* Examine a list that is to be read, and compute what has to be computed first. */
static Status examine_to_read(Instance *instance, const char *call, Kind kind, const fmi2ValueReference vr[],
                              size_t n, const void *values, List *list)
{
    if (examine(instance, call, kind, vr, n, values, list) != CALL_OK)
        return CALL_ERROR;
    return begin_to_read(instance, call, list->flags);
}

/* Examine a list that is to be written; the values are examined later. */
static Status examine_to_write(Instance *instance, const char *call, Kind kind, const fmi2ValueReference vr[],
                               size_t n, const void *values, List *list)
{
    if (examine(instance, call, kind, vr, n, values, list) != CALL_OK)
        return CALL_ERROR;
    return check_order(instance, SET, call);
}

/* Refuse reals that are not accepted, of variables that follow one on the other from `place` on. */
static Status check_run(Instance *instance, const char *call, const Port *port, int place, size_t n,
                        const fmi2Real values[])
{
    for (; n > 0; port++) {
        const size_t left = (size_t)(port->first + port->size - place), here = n < left ? n : left;
        if (check_numbers(instance, call, port, place, here, values) != CALL_OK)
            return CALL_ERROR;
        place += (int)here;
        values += here;
        n -= here;
    }
    return CALL_OK;
}

static fmi2Status finish(Instance *instance, const char *call, size_t n, const List *list)
{
    return n == 0 ? fmi2OK : (fmi2Status)finish_writing(instance, call, list->flags);
}

fmi2Status FMI2(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[])
{
    const Instance *instance = c;
    const fmi2ValueReference first = first_reference(REAL);
    List list;
    size_t k, run;

    if (examine_to_read(c, "getReal", REAL, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k += run) {
        run = k == 0 ? list.run : run_of(vr + k, n - k);
        memcpy(values + k, instance->component.real + (vr[k] - first), run * sizeof *values);
    }
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer values[])
{
    const Instance *instance = c;
    const fmi2ValueReference first = first_reference(INTEGER);
    List list;
    size_t k, run;

    if (examine_to_read(c, "getInteger", INTEGER, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k += run) {
        run = k == 0 ? list.run : run_of(vr + k, n - k);
        memcpy(values + k, instance->component.integer + (vr[k] - first), run * sizeof *values);
    }
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean values[])
{
    const Instance *instance = c;
    const fmi2ValueReference first = first_reference(BOOLEAN);
    List list;
    size_t k, run;

    if (examine_to_read(c, "getBoolean", BOOLEAN, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k += run) {
        run = k == 0 ? list.run : run_of(vr + k, n - k);
        memcpy(values + k, instance->component.boolean + (vr[k] - first), run * sizeof *values);
    }
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String values[])
{
    const Instance *instance = c;
    const fmi2ValueReference first = first_reference(STRING);
    List list;
    size_t k;

    if (examine_to_read(c, "getString", STRING, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        values[k] = instance->component.string[vr[k] - first];
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[])
{
    static const char call[] = "setReal";
    const fmi2ValueReference first = first_reference(REAL);
    Instance *instance = c;
    List list;
    size_t k, run;

    if (examine_to_write(instance, call, REAL, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k += run) {
        run = k == 0 ? list.run : run_of(vr + k, n - k);
        if (check_run(instance, call, port_of(vr[k]), (int)(vr[k] - first), run, values + k) != CALL_OK)
            return fmi2Error;
    }
    for (k = 0; k < n; k += run) {
        run = k == 0 ? list.run : run_of(vr + k, n - k);
        memcpy(instance->component.real + (vr[k] - first), values + k, run * sizeof *values);
    }
    return finish(instance, call, n, &list);
}

fmi2Status FMI2(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer values[])
{
    static const char call[] = "setInteger";
    const fmi2ValueReference first = first_reference(INTEGER);
    Instance *instance = c;
    List list;
    size_t k;

    if (examine_to_write(instance, call, INTEGER, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        if (check_number(instance, call, port_of(vr[k]), (int)(vr[k] - first), values[k]) != CALL_OK)
            return fmi2Error;
    for (k = 0; k < n; k++)
        instance->component.integer[vr[k] - first] = values[k];
    return finish(instance, call, n, &list);
}

fmi2Status FMI2(fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean values[])
{
    static const char call[] = "setBoolean";
    const fmi2ValueReference first = first_reference(BOOLEAN);
    Instance *instance = c;
    List list;
    size_t k;

    if (examine_to_write(instance, call, BOOLEAN, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        if (check_boolean(instance, call, port_of(vr[k]), (int)(vr[k] - first), values[k]) != CALL_OK)
            return fmi2Error;
    for (k = 0; k < n; k++)
        instance->component.boolean[vr[k] - first] = values[k] != 0;
    return finish(instance, call, n, &list);
}

fmi2Status FMI2(fmi2SetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String values[])
{
    static const char call[] = "setString";
    const fmi2ValueReference first = first_reference(STRING);
    Instance *instance = c;
    List list;
    size_t k;

    if (examine_to_write(instance, call, STRING, vr, n, values, &list) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < n; k++)
        if (check_text(instance, call, port_of(vr[k]), (int)(vr[k] - first), values[k], k + 1) != CALL_OK)
            return fmi2Error;
    for (k = 0; k < n; k++)
        strcpy(instance->component.string[vr[k] - first], values[k]);
    return finish(instance, call, n, &list);
}
