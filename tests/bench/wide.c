/* A small FMU (FMI 2.0 co-simulation) with WIDTH real inputs u and as many real outputs y: y = u / 2 + 1 at each step.

   Value references are 0 to WIDTH - 1 for the inputs, WIDTH to 2 WIDTH - 1 for the outputs. What a step and an exchange
   cost here is little beside what a master makes of them. */

#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

typedef struct {
    double values[2 * WIDTH];
} Instance;

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name; (void)resources; (void)callbacks; (void)visible; (void)logging;
    return type == fmi2CoSimulation && strcmp(guid, GUID) == 0 ? calloc(1, sizeof(Instance)) : NULL;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    double *values = ((Instance *)component)->values;
    (void)time; (void)step; (void)no_return;
    for (size_t i = 0; i < WIDTH; i++) values[WIDTH + i] = 0.5 * values[i] + 1.0;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    const double *values = ((Instance *)component)->values;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= 2 * WIDTH) return fmi2Error;
        value[i] = values[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    double *values = ((Instance *)component)->values;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= WIDTH) return fmi2Error;
        values[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) { memset(c, 0, sizeof(Instance)); return fmi2OK; }
