/* Inquiries of a status, and what no FMU of flexsat has, as their model descriptions say. */
#include "fmi2_instance.h"

/* Refuse an inquiry unless a step was made or could be: steps are never pending nor discarded. */
static fmi2Status inquire(Instance *instance, const char *call, const void *value)
{
    if (instance == NULL)
        return fmi2Error;
    if (instance->phase != STEPPING && instance->phase != TERMINATED)
        return (fmi2Status)refuse_call(instance, call, "not allowed %s",
                           instance->phase == FAILED ? "after a refused call" : "before initialisation has ended");
    if (value == NULL)
        return (fmi2Status)refuse_call(instance, call, "the value goes to a NULL pointer");
    return fmi2OK;
}

static fmi2Status without_answer(Instance *instance, const char *call, fmi2StatusKind asked)
{
    log_to_host(&instance->host, instance->name, CALL_DISCARD, "%s: no answer to kind %d", call, (int)asked);
    return fmi2Discard;
}

fmi2Status FMI2(fmi2GetStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Status *value)
{
    const fmi2Status status = inquire(c, "getStatus", value);

    return status != fmi2OK ? status : without_answer(c, "getStatus", asked);
}

fmi2Status FMI2(fmi2GetRealStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Real *value)
{
    const Instance *instance = c;
    const fmi2Status status = inquire(c, "getRealStatus", value);

    if (status != fmi2OK)
        return status;
    if (asked != fmi2LastSuccessfulTime)
        return without_answer(c, "getRealStatus", asked);
    *value = instance->present;
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetIntegerStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Integer *value)
{
    const fmi2Status status = inquire(c, "getIntegerStatus", value);

    return status != fmi2OK ? status : without_answer(c, "getIntegerStatus", asked);
}

fmi2Status FMI2(fmi2GetBooleanStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Boolean *value)
{
    const fmi2Status status = inquire(c, "getBooleanStatus", value);

    if (status != fmi2OK)
        return status;
    if (asked != fmi2Terminated)
        return without_answer(c, "getBooleanStatus", asked);
    *value = 0;
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetStringStatus)(fmi2Component c, fmi2StatusKind asked, fmi2String *value)
{
    const fmi2Status status = inquire(c, "getStringStatus", value);

    return status != fmi2OK ? status : without_answer(c, "getStringStatus", asked);
}

fmi2Status FMI2(fmi2CancelStep)(fmi2Component c)
{
    if (c == NULL)
        return fmi2Error;
    return (fmi2Status)refuse_call(c, "cancelStep", "no step is in progress: fmi2DoStep returns at its end");
}

static fmi2Status unsupported(fmi2Component c, const char *call)
{
    return c == NULL ? fmi2Error : (fmi2Status)refuse_call(c, call, "not supported; the model description says so");
}

fmi2Status FMI2(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                             const fmi2Integer order[], const fmi2Real values[])
{
    (void)vr, (void)n, (void)order, (void)values;
    return unsupported(c, "SetRealInputDerivatives");
}

fmi2Status FMI2(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                              const fmi2Integer order[], fmi2Real values[])
{
    (void)vr, (void)n, (void)order, (void)values;
    return unsupported(c, "GetRealOutputDerivatives");
}
