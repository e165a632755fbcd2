/* An FMI 2.0 co-simulation slave that stamps its steps and reads stamps: measures the age of values that a master transfers.
 *
 * A step begun at t puts out t + EPOCH, and compares its input with its own t. The epoch distinguishes a stamp from
 * whatever start value a master gives a connection.
 *
 * Variables: 0 input seen; outputs 1 stamp, 2 least, 3 largest age of what was seen [s], 4 stamps seen.
 */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define EPOCH 1.0 /* s */

enum { SEEN, STAMP, LEAST, LARGEST, COUNT, VARIABLES };

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)resources, (void)functions, (void)visible, (void)logging;
    return strcmp(guid, GUID) ? NULL : calloc(VARIABLES, sizeof(double));
}

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
