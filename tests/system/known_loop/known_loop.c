/* Two FMI 2.0 co-simulation slaves whose loop is known in closed form. Compiled once with PLANT defined, once without.
 *
 * plant:      x[k+1] = a x[k] + (1 - a) GAIN u[k], a = exp(-step / LAG); y = x + noise, uniform, from a seed
 * controller: u[k] = -(KP y[k] + KI (y[0] + ... + y[k]))
 *
 * Variables: 0 input, 1 output, 2 parameter (noise's half width, of the plant alone).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define KP 0.9
#define KI 0.05
#define GAIN 2.0
#define LAG 0.05

typedef struct {
    double value[3], state;
    unsigned long long random;
} Slave;

static void output(Slave *slave)
{
#ifdef PLANT
    slave->random = slave->random * 6364136223846793005ULL + 1442695040888963407ULL; /* Knuth's MMIX */
    slave->value[1] = slave->state + slave->value[2] * (2.0 * (double)(slave->random >> 11) / 9007199254740992.0 - 1.0);
#else
    slave->value[1] = -(KP * slave->value[0] + KI * slave->state);
#endif
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)resources, (void)functions, (void)visible, (void)logging;
    Slave *slave = strcmp(guid, GUID) ? NULL : calloc(1, sizeof(Slave));
    if (slave != NULL)
        slave->random = 7;
    return slave;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    for (size_t i = 0; i < n; i++)
        value[i] = ((Slave *)c)->value[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++)
        ((Slave *)c)->value[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state)
{
    Slave *slave = c;
    (void)time, (void)no_set_state;
#ifdef PLANT
    double a = exp(-step / LAG);
    slave->state = a * slave->state + (1.0 - a) * GAIN * slave->value[0];
#else
    (void)step;
    slave->state += slave->value[0];
#endif
    output(slave);
    return fmi2OK;
}
