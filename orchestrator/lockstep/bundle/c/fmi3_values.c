/* Values as FMI 3.0 has them: a value reference is that of a variable with all its elements, or of the time. Lists are
examined before any value is written. */
#include "access.h"
#include "fmi3_functions.h"
#include "memory.h"
#include "messages.h"
#include "values.h"

enum { TIME = 0 }; /* value reference of the independent variable; those of the variables follow it */

static const char *const type_names[] = {"Float64", "Int32", "Boolean", "String", "Int64"};

static const variable_t *variable_of(const bundle_t *bundle, fmi3ValueReference reference)
{
    return reference != TIME && reference <= bundle->variable_count ? &bundle->variables[reference - 1] : NULL;
}

static int is_time(uint32_t shown, fmi3ValueReference reference)
{
    return shown == REAL && reference == TIME;
}

/* Return the ports behind variables, the time left out, and their number; NULL and a message if they are no such
variables, or have another number of elements. */
static fmi2ValueReference *ports_of(bundle_t *bundle, const char *call, uint32_t shown,
                                    const fmi3ValueReference references[], size_t count, size_t size, size_t *number)
{
    size_t elements = 0, times = 0;
    fmi2ValueReference *ports;

    for (size_t k = 0; k < count; k++) {
        const variable_t *variable = variable_of(bundle, references[k]);
        if (is_time(shown, references[k]))
            times++;
        else if (variable == NULL || variable->shown != shown) {
            refuse(bundle, "%s: value reference %u: there is no %s of this number", call, references[k],
                   type_names[shown]);
            return NULL;
        } else
            elements += variable->count;
    }
    if (size != elements + times) {
        refuse(bundle, "%s: %lu values, and the variables have %lu elements", call, (unsigned long)size,
               (unsigned long)(elements + times));
        return NULL;
    }
    ports = grown(&bundle->expanded, (elements + 1) * sizeof *ports);
    if (ports == NULL) {
        refuse(bundle, "%s: there is no memory", call);
        return NULL;
    }
    *number = 0;
    for (size_t k = 0; k < count; k++) {
        const variable_t *variable = variable_of(bundle, references[k]);
        for (uint32_t n = 0; variable != NULL && n < variable->count; n++)
            ports[(*number)++] = variable->first + n;
    }
    return ports;
}

/* Return memory for the values of ports in the type of the bundle. */
static void *values_of(bundle_t *bundle, const char *call, size_t number)
{
    void *values = grown(&bundle->given, (number + 1) * sizeof(double));

    if (values == NULL)
        refuse(bundle, "%s: there is no memory", call);
    return values;
}

/* Return the ports that are to be set; NULL and a message if they cannot be. */
static fmi2ValueReference *ports_to_set(bundle_t *bundle, const char *call, uint32_t shown,
                                        const fmi3ValueReference references[], size_t count, const void *values,
                                        size_t size, size_t *number)
{
    fmi2ValueReference *ports;

    if (bundle == NULL || !may_set(bundle, call, count, references, size == 0 ? "" : values))
        return NULL;
    ports = ports_of(bundle, call, shown, references, count, size, number);
    for (size_t k = 0; ports != NULL && k < count; k++) {
        const variable_t *variable = variable_of(bundle, references[k]);
        if (variable == NULL)
            refuse(bundle, "%s: value reference %u: is the time, which cannot be set", call, references[k]);
        if (variable == NULL || refuse_set(bundle, &bundle->ports[variable->first], references[k]) != fmi2OK)
            return NULL;
    }
    return ports;
}

static fmi2ValueReference *ports_to_get(bundle_t *bundle, const char *call, uint32_t shown,
                                        const fmi3ValueReference references[], size_t count, const void *values,
                                        size_t size, size_t *number)
{
    if (bundle == NULL || !may_get(bundle, call, count, references, size == 0 ? "" : values))
        return NULL;
    return ports_of(bundle, call, shown, references, count, size, number);
}

static fmi3Status write_ports(bundle_t *bundle, int type, const fmi2ValueReference *ports, size_t number,
                              const void *values)
{
    return (fmi3Status)noted_fatal(bundle, set_ports(bundle, type, ports, number, values));
}

static fmi3Status read_ports(bundle_t *bundle, int type, const fmi2ValueReference *ports, size_t number, void *values)
{
    return (fmi3Status)noted_fatal(bundle, get_ports(bundle, type, ports, number, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t size)
{
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_set(instance, "fmi3SetFloat64", REAL, references, count, values, size, &number);

    return ports == NULL ? fmi3Error : write_ports(instance, REAL, ports, number, values);
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        const fmi3Int32 values[], size_t size)
{
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_set(instance, "fmi3SetInt32", INTEGER, references, count, values, size, &number);

    return ports == NULL ? fmi3Error : write_ports(instance, INTEGER, ports, number, values);
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const fmi3String values[], size_t size)
{
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_set(instance, "fmi3SetString", STRING, references, count, values, size, &number);

    return ports == NULL ? fmi3Error : write_ports(instance, STRING, ports, number, (const void *)values);
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Boolean values[], size_t size)
{
    static const char call[] = "fmi3SetBoolean";
    const unsigned char *bytes = (const void *)values; /* whatever a host gives for a Boolean */
    size_t number = 0;
    const fmi2ValueReference *ports = ports_to_set(instance, call, BOOLEAN, references, count, values, size, &number);
    int32_t *wide = ports == NULL ? NULL : values_of(instance, call, number);

    if (wide == NULL)
        return fmi3Error;
    for (size_t k = 0; k < number; k++)
        wide[k] = bytes[k] != 0;
    return write_ports(instance, BOOLEAN, ports, number, wide);
}

/* Enumerations, which have 32 bits inside. */
fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        const fmi3Int64 values[], size_t size)
{
    static const char call[] = "fmi3SetInt64";
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_set(instance, call, ENUMERATION, references, count, values, size, &number);
    int32_t *narrow = ports == NULL ? NULL : values_of(instance, call, number);

    if (narrow == NULL)
        return fmi3Error;
    for (size_t k = 0; k < number; k++) {
        if (values[k] < INT32_MIN || values[k] > INT32_MAX)
            return (fmi3Status)refuse(instance, "%s: %lld: an enumeration has values of 32 bits", call,
                                      (long long)values[k]);
        narrow[k] = (int32_t)values[k];
    }
    return write_ports(instance, INTEGER, ports, number, narrow);
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t size)
{
    static const char call[] = "fmi3GetFloat64";
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_get(instance, call, REAL, references, count, values, size, &number);
    double *found = number == size ? values : NULL;
    fmi3Status status;

    if (ports == NULL)
        return fmi3Error;
    if (found == NULL)
        found = values_of(instance, call, number);
    if (found == NULL)
        return fmi3Error;
    status = read_ports(instance, REAL, ports, number, found);
    if (found == values || status > fmi3Warning)
        return status;
    for (size_t k = 0; k < count; k++) {
        const variable_t *variable = variable_of(instance, references[k]);
        if (variable == NULL)
            *values++ = time_now(instance);
        else
            for (uint32_t n = 0; n < variable->count; n++)
                *values++ = *found++;
    }
    return status;
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        fmi3Int32 values[], size_t size)
{
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_get(instance, "fmi3GetInt32", INTEGER, references, count, values, size, &number);

    return ports == NULL ? fmi3Error : read_ports(instance, INTEGER, ports, number, values);
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         fmi3String values[], size_t size)
{
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_get(instance, "fmi3GetString", STRING, references, count, values, size, &number);

    return ports == NULL ? fmi3Error : read_ports(instance, STRING, ports, number, (void *)values);
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Boolean values[], size_t size)
{
    static const char call[] = "fmi3GetBoolean";
    size_t number = 0;
    const fmi2ValueReference *ports = ports_to_get(instance, call, BOOLEAN, references, count, values, size, &number);
    int32_t *wide = ports == NULL ? NULL : values_of(instance, call, number);
    fmi3Status status = wide == NULL ? fmi3Error : read_ports(instance, BOOLEAN, ports, number, wide);

    for (size_t k = 0; status <= fmi3Warning && k < number; k++)
        values[k] = wide[k] != 0;
    return status;
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        fmi3Int64 values[], size_t size)
{
    static const char call[] = "fmi3GetInt64";
    size_t number = 0;
    const fmi2ValueReference *ports =
        ports_to_get(instance, call, ENUMERATION, references, count, values, size, &number);
    int32_t *narrow = ports == NULL ? NULL : values_of(instance, call, number);
    fmi3Status status = narrow == NULL ? fmi3Error : read_ports(instance, INTEGER, ports, number, narrow);

    for (size_t k = 0; status <= fmi3Warning && k < number; k++)
        values[k] = narrow[k];
    return status;
}
