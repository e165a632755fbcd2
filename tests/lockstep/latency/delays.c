/* An FMI 2.0 co-simulation slave with a known delay from each input to each output. An input is read when a step begins.
 *
 * Reals     0 u, 1 v, 2 slow, 3 gated, 4 idle            inputs
 *           5 scale                                      parameter
 *           6 direct = scale u                           0 steps, feedthrough
 *           7 late1, 8 late3 = v                         1 and 3 steps
 *           9 sampled = slow, every 4th step             0 to 3 steps, feedthrough
 *          10 held = gated while the gate is up          0 steps, feedthrough
 *          11 integral of u, true at the step's end      0 steps, vanishing with the step
 *          12 coarse = floor(64 u) / 64                  0 steps, feedthrough, quantised
 *          13 noise: the time of day when it was made, so that two instances differ
 * Booleans  0 gate                                       input
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2Functions.h"

enum { U, V, SLOW, GATED, IDLE, SCALE, DIRECT, LATE1, LATE3, SAMPLED, HELD, INTEGRAL, COARSE, NOISE, REALS };

typedef struct {
    double real[REALS], past[3];
    int gate, count;
} Slave;

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    return (double)time.tv_nsec;
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)resources, (void)functions, (void)visible, (void)logging;
    Slave *slave = strcmp(guid, GUID) ? NULL : calloc(1, sizeof(Slave));
    if (slave != NULL)
        slave->real[SCALE] = 1.0, slave->real[NOISE] = now();
    return slave;
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
        value[i] = ((Slave *)c)->real[vr[i]];
#ifdef AT_ONCE
    for (size_t i = 0; i < n; i++)
        if (vr[i] == DIRECT)
            value[i] = ((Slave *)c)->real[SCALE] * ((Slave *)c)->real[U];
#endif
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++)
        ((Slave *)c)->real[vr[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
{
    (void)vr, (void)n;
    ((Slave *)c)->gate = value[0];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state)
{
    Slave *slave = c;
    double *real = slave->real;
    (void)time, (void)no_set_state;
#ifdef FIXED
    if (fabs(step - FIXED) > 1e-9)
        return fmi2Discard;
#endif
#ifdef CRASHES
    if (slave->count == 20)
        *(volatile int *)0 = 1;
#endif
    real[LATE1] = slave->past[0];
    real[LATE3] = slave->past[2];
    slave->past[2] = slave->past[1], slave->past[1] = slave->past[0], slave->past[0] = real[V];
    real[DIRECT] = real[SCALE] * real[U];
    if (slave->count % 4 == 3)
        real[SAMPLED] = real[SLOW];
    if (slave->gate)
        real[HELD] = real[GATED];
    real[INTEGRAL] += step * real[U];
    real[COARSE] = floor(64.0 * real[U]) / 64.0;
    slave->count++;
    return fmi2OK;
}

#ifdef STATE
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (*state == NULL)
        *state = malloc(sizeof(Slave));
    return memcpy(*state, c, sizeof(Slave)), fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { return memcpy(c, state, sizeof(Slave)), fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}
#endif

/* What nobody calls here, but a host may look for when it loads the library. */
#define UNUSED(name, ...) fmi2Status name(fmi2Component c, __VA_ARGS__) { return (void)c, fmi2Error; }
#pragma GCC diagnostic ignored "-Wunused-parameter"
fmi2Status fmi2Reset(fmi2Component c) { return (void)c, fmi2Error; }
fmi2Status fmi2CancelStep(fmi2Component c) { return (void)c, fmi2Error; }
UNUSED(fmi2GetInteger, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
UNUSED(fmi2GetBoolean, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
UNUSED(fmi2GetString, const fmi2ValueReference vr[], size_t n, fmi2String value[])
UNUSED(fmi2SetInteger, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[])
UNUSED(fmi2SetString, const fmi2ValueReference vr[], size_t n, const fmi2String value[])
#ifndef STATE
UNUSED(fmi2GetFMUstate, fmi2FMUstate *state)
UNUSED(fmi2SetFMUstate, fmi2FMUstate state)
UNUSED(fmi2FreeFMUstate, fmi2FMUstate *state)
#endif
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
