/* The functions of FMI 2.0 that set and get values and states, and those of what a bundle does not have. */
#include "access.h"
#include "messages.h"
#include "states.h"
#include "values.h"

#define VALUES(name, value, type, function)                                                                     \
    FMI2_EXPORT fmi2Status name(fmi2Component instance, const fmi2ValueReference references[], size_t count,    \
                                value values[]);                                                                \
    fmi2Status name(fmi2Component instance, const fmi2ValueReference references[], size_t count, value values[]) \
    {                                                                                                           \
        return function(instance, #name, type, references, count, values);                                      \
    }

FMI2_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component instance, fmi2FMUstate *state);
FMI2_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component instance, fmi2FMUstate state);
FMI2_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component instance, fmi2FMUstate *state);
FMI2_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component instance, fmi2FMUstate state, size_t *size);
FMI2_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component instance, fmi2FMUstate state, fmi2Byte bytes[], size_t size);
FMI2_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component instance, const fmi2Byte bytes[], size_t size,
                                               fmi2FMUstate *state);
FMI2_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknown[],
                                                    size_t unknown_count, const fmi2ValueReference known[],
                                                    size_t known_count, const fmi2Real seed[], fmi2Real result[]);
FMI2_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance, const fmi2ValueReference references[],
                                                   size_t count, const fmi2Integer orders[], const fmi2Real values[]);
FMI2_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component instance, const fmi2ValueReference references[],
                                                    size_t count, const fmi2Integer orders[], fmi2Real values[]);
FMI2_EXPORT fmi2Status fmi2CancelStep(fmi2Component instance);
FMI2_EXPORT fmi2Status fmi2GetStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Status *value);
FMI2_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Real *value);
FMI2_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Integer *value);
FMI2_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Boolean *value);
FMI2_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component instance, fmi2StatusKind kind, fmi2String *value);

static fmi2Status set(bundle_t *bundle, const char *call, int type, const fmi2ValueReference references[],
                      size_t count, const void *values)
{
    if (bundle == NULL || !may_set(bundle, call, count, references, values))
        return fmi2Error;
    return noted_fatal(bundle, set_ports(bundle, type, references, count, values));
}

static fmi2Status get(bundle_t *bundle, const char *call, int type, const fmi2ValueReference references[],
                      size_t count, void *values)
{
    if (bundle == NULL || !may_get(bundle, call, count, references, values))
        return fmi2Error;
    return noted_fatal(bundle, get_ports(bundle, type, references, count, values));
}

VALUES(fmi2SetReal, const fmi2Real, REAL, set)
VALUES(fmi2SetInteger, const fmi2Integer, INTEGER, set)
VALUES(fmi2SetBoolean, const fmi2Boolean, BOOLEAN, set)
VALUES(fmi2SetString, const fmi2String, STRING, set)
VALUES(fmi2GetReal, fmi2Real, REAL, get)
VALUES(fmi2GetInteger, fmi2Integer, INTEGER, get)
VALUES(fmi2GetBoolean, fmi2Boolean, BOOLEAN, get)
VALUES(fmi2GetString, fmi2String, STRING, get)

static int has_state(const bundle_t *bundle, const char *call, const void *given)
{
    return bundle != NULL && may_have_state(bundle, call, given);
}

fmi2Status fmi2GetFMUstate(fmi2Component instance, fmi2FMUstate *state)
{
    static const char call[] = "fmi2GetFMUstate";

    return has_state(instance, call, state) ? get_state(instance, call, state) : fmi2Error;
}

fmi2Status fmi2SetFMUstate(fmi2Component instance, fmi2FMUstate state)
{
    static const char call[] = "fmi2SetFMUstate";

    return has_state(instance, call, state) ? set_state(instance, call, state) : fmi2Error;
}

fmi2Status fmi2FreeFMUstate(fmi2Component instance, fmi2FMUstate *state)
{
    return instance == NULL ? fmi2Error : free_state(instance, "fmi2FreeFMUstate", state);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component instance, fmi2FMUstate state, size_t *size)
{
    static const char call[] = "fmi2SerializedFMUstateSize";

    return has_state(instance, call, size) ? state_size(instance, call, state, size) : fmi2Error;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component instance, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    static const char call[] = "fmi2SerializeFMUstate";

    return has_state(instance, call, bytes) ? serialize(instance, call, state, bytes, size) : fmi2Error;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component instance, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    static const char call[] = "fmi2DeSerializeFMUstate";

    if (!has_state(instance, call, bytes) || !has_state(instance, call, state))
        return fmi2Error;
    return deserialize(instance, call, bytes, size, state);
}

/* Refuse what the capability flags deny; asked for nothing, it is fine. */
static fmi2Status lacks(const bundle_t *bundle, const char *call, size_t count)
{
    if (bundle == NULL)
        return fmi2Error;
    return count == 0 ? fmi2OK : refuse(bundle, "%s: the FMU has no derivatives", call);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknown[],
                                        size_t unknown_count, const fmi2ValueReference known[], size_t known_count,
                                        const fmi2Real seed[], fmi2Real result[])
{
    (void)unknown, (void)known, (void)known_count, (void)seed, (void)result;
    return lacks(instance, "fmi2GetDirectionalDerivative", unknown_count);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance, const fmi2ValueReference references[], size_t count,
                                       const fmi2Integer orders[], const fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return lacks(instance, "fmi2SetRealInputDerivatives", count);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component instance, const fmi2ValueReference references[], size_t count,
                                        const fmi2Integer orders[], fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return lacks(instance, "fmi2GetRealOutputDerivatives", count);
}

fmi2Status fmi2CancelStep(fmi2Component instance)
{
    return instance == NULL ? fmi2Error : refuse(instance, "fmi2CancelStep: no step is under way");
}

static fmi2Status no_status(const bundle_t *bundle, const char *call)
{
    if (bundle == NULL)
        return fmi2Error;
    refuse(bundle, "%s: there is no such status", call);
    return fmi2Discard;
}

fmi2Status fmi2GetStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return no_status(instance, "fmi2GetStatus");
}

fmi2Status fmi2GetRealStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Real *value)
{
    const bundle_t *bundle = instance;

    if (bundle == NULL || kind != fmi2LastSuccessfulTime || value == NULL)
        return no_status(bundle, "fmi2GetRealStatus");
    *value = time_now(bundle);
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return no_status(instance, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component instance, fmi2StatusKind kind, fmi2Boolean *value)
{
    const bundle_t *bundle = instance;

    if (bundle == NULL || kind != fmi2Terminated || value == NULL)
        return no_status(bundle, "fmi2GetBooleanStatus");
    *value = bundle->ended ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component instance, fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return no_status(instance, "fmi2GetStringStatus");
}
