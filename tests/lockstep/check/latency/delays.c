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

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)resources, (void)functions, (void)visible, (void)logging;
    Slave *slave = strcmp(guid, GUID) ? NULL : calloc(1, sizeof(Slave));
    if (slave != NULL)
        slave->real[SCALE] = 1.0, slave->real[NOISE] = now();
    return slave;
}

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
#ifdef GUARDED /* what is near passes at once, the rest waits a step */
    if (fabs(real[V] - 0.3) < 0.01)
        real[LATE1] = real[V];
#endif
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
size_t state_size = sizeof(Slave);
#endif
