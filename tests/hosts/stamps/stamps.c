/* An FMI 2.0 co-simulation slave that stamps and reads stamps: how old is what a master hands over?
 *
 * A step begun at t puts out t + EPOCH, and compares what stands on its input with its own t. The epoch tells a stamp from
 * whatever a master starts a connection with.
 *
 * Variables: 0 input seen; outputs 1 stamp, 2 least, 3 largest age of what was seen [s], 4 stamps seen.
 */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define EPOCH 1.0 /* s */

enum { SEEN, STAMP, LEAST, LARGEST, COUNT, VARIABLES };

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)resources, (void)functions, (void)visible, (void)logging;
    return strcmp(guid, GUID) ? NULL : calloc(VARIABLES, sizeof(double));
}

void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return fmi2OK;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_defined, fmi2Real stop)
{
    (void)c, (void)defined, (void)tolerance, (void)start, (void)stop_defined, (void)stop;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    for (size_t i = 0; i < n; i++)
        value[i] = ((double *)c)[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++)
        ((double *)c)[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state)
{
    double *value = c, now = time + EPOCH;
    (void)step, (void)no_set_state;
    if (value[SEEN] >= EPOCH) {
        double age = now - value[SEEN];
        if (value[COUNT] == 0.0 || age < value[LEAST])
            value[LEAST] = age;
        if (value[COUNT] == 0.0 || age > value[LARGEST])
            value[LARGEST] = age;
        value[COUNT] += 1.0;
    }
    value[STAMP] = now;
    return fmi2OK;
}

/* What nobody calls here, but a host looks for when it loads the library. */
#define UNUSED(name, ...) fmi2Status name(fmi2Component c, __VA_ARGS__) { return (void)c, fmi2Error; }
#pragma GCC diagnostic ignored "-Wunused-parameter"
fmi2Status fmi2Reset(fmi2Component c) { return (void)c, fmi2Error; }
fmi2Status fmi2CancelStep(fmi2Component c) { return (void)c, fmi2Error; }
UNUSED(fmi2GetInteger, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
UNUSED(fmi2GetBoolean, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
UNUSED(fmi2GetString, const fmi2ValueReference vr[], size_t n, fmi2String value[])
UNUSED(fmi2SetInteger, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[])
UNUSED(fmi2SetBoolean, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
UNUSED(fmi2SetString, const fmi2ValueReference vr[], size_t n, const fmi2String value[])
UNUSED(fmi2GetFMUstate, fmi2FMUstate *state)
UNUSED(fmi2SetFMUstate, fmi2FMUstate state)
UNUSED(fmi2FreeFMUstate, fmi2FMUstate *state)
UNUSED(fmi2SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
UNUSED(fmi2SerializeFMUstate, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
UNUSED(fmi2DeSerializeFMUstate, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
UNUSED(fmi2GetDirectionalDerivative, const fmi2ValueReference unknown[], size_t n, const fmi2ValueReference known[],
       size_t k, const fmi2Real seed[], fmi2Real found[])
UNUSED(fmi2SetRealInputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
       const fmi2Real value[])
UNUSED(fmi2GetRealOutputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
       fmi2Real value[])
UNUSED(fmi2GetStatus, const fmi2StatusKind kind, fmi2Status *value)
UNUSED(fmi2GetRealStatus, const fmi2StatusKind kind, fmi2Real *value)
UNUSED(fmi2GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *value)
UNUSED(fmi2GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value)
UNUSED(fmi2GetStringStatus, const fmi2StatusKind kind, fmi2String *value)
