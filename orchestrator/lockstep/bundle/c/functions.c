/* The functions of FMI 2.0 that set and get values and states, and those of what a bundle does not have. */
#include "components.h"
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

FMI2_EXPORT const char *fmi2GetTypesPlatform(void);
FMI2_EXPORT const char *fmi2GetVersion(void);
FMI2_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component instance, fmi2Boolean on, size_t count,
                                           const fmi2String categories[]);
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

static fmi2Status noted(bundle_t *bundle, fmi2Status status)
{
    if (status >= fmi2Error && bundle->life == FATAL)
        return fmi2Fatal;
    return status;
}

static fmi2Status set(bundle_t *bundle, const char *call, int type, const fmi2ValueReference references[],
                      size_t count, const void *values)
{
    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life > STEPPING)
        return refuse(bundle, "%s: is not allowed after the end or a failure", call);
    if (count > 0 && (references == NULL || values == NULL))
        return refuse(bundle, "%s: has %lu references, and no array of them or of the values", call,
                      (unsigned long)count);
    return noted(bundle, set_ports(bundle, type, references, count, values));
}

static fmi2Status get(bundle_t *bundle, const char *call, int type, const fmi2ValueReference references[],
                      size_t count, void *values)
{
    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life == FATAL)
        return refuse(bundle, "%s: is not allowed after a fatal failure", call);
    if (count > 0 && (references == NULL || values == NULL))
        return refuse(bundle, "%s: has %lu references, and no array of them or of the values", call,
                      (unsigned long)count);
    return noted(bundle, get_ports(bundle, type, references, count, values));
}

VALUES(fmi2SetReal, const fmi2Real, REAL, set)
VALUES(fmi2SetInteger, const fmi2Integer, INTEGER, set)
VALUES(fmi2SetBoolean, const fmi2Boolean, BOOLEAN, set)
VALUES(fmi2SetString, const fmi2String, STRING, set)
VALUES(fmi2GetReal, fmi2Real, REAL, get)
VALUES(fmi2GetInteger, fmi2Integer, INTEGER, get)
VALUES(fmi2GetBoolean, fmi2Boolean, BOOLEAN, get)
VALUES(fmi2GetString, fmi2String, STRING, get)

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Status fmi2SetDebugLogging(fmi2Component instance, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    bundle_t *bundle = instance;
    fmi2Status worst = fmi2OK;

    (void)count, (void)categories; /* components have categories of their own */
    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life == FATAL)
        return refuse(bundle, "fmi2SetDebugLogging: is not allowed after a fatal failure");
    bundle->logging = on ? fmi2True : fmi2False;
    for (uint32_t k = 0; k < bundle->component_count && worst < fmi2Fatal; k++) {
        component_t *component = &bundle->components[k];
        worst = worse(worst, judge(component, "fmi2SetDebugLogging",
                                   component->call.set_debug_logging(component->instance, bundle->logging, 0, NULL)));
    }
    return worst;
}

/* Whether the state may be asked for or set; a message if not. */
static int stateful(const bundle_t *bundle, const char *call, const void *given)
{
    if (bundle == NULL)
        return 0;
    if (bundle->life == FATAL)
        refuse(bundle, "%s: is not allowed after a fatal failure", call);
    else if (given == NULL)
        refuse(bundle, "%s: has no place for the state, or no state", call);
    else
        return 1;
    return 0;
}

fmi2Status fmi2GetFMUstate(fmi2Component instance, fmi2FMUstate *state)
{
    return stateful(instance, "fmi2GetFMUstate", state) ? get_state(instance, state) : fmi2Error;
}

fmi2Status fmi2SetFMUstate(fmi2Component instance, fmi2FMUstate state)
{
    return stateful(instance, "fmi2SetFMUstate", state) ? set_state(instance, state) : fmi2Error;
}

fmi2Status fmi2FreeFMUstate(fmi2Component instance, fmi2FMUstate *state)
{
    return instance == NULL ? fmi2Error : free_state(instance, state);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component instance, fmi2FMUstate state, size_t *size)
{
    if (!stateful(instance, "fmi2SerializedFMUstateSize", size))
        return fmi2Error;
    return state_size(instance, state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component instance, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return stateful(instance, "fmi2SerializeFMUstate", bytes) ? serialize(instance, state, bytes, size) : fmi2Error;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component instance, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    if (!stateful(instance, "fmi2DeSerializeFMUstate", bytes) || !stateful(instance, "fmi2DeSerializeFMUstate", state))
        return fmi2Error;
    return deserialize(instance, bytes, size, state);
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
