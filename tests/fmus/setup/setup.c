/* An FMU of FMI 2.0 whose fmi2SetupExperiment initialises all variables, as code that 20-sim generates does: what was
   set before it is lost. RESETS_LATE loses what is set after it too; without either nothing is lost. y is p, v is u, and
   tolerance is what the host passed, or -1. */

#include <stdlib.h>

#include "fmi2Functions.h"

enum { P, U, Y, V, TOLERANCE, REALS };

typedef struct {
    double real[REALS];
    int whole;
} Instance;

static const Instance STARTS = {.real = {[P] = 0.5, [TOLERANCE] = -1.0}, .whole = 3};

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    Instance *it = malloc(sizeof *it);
    *it = STARTS;
    return it;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean ends, fmi2Real stop) {
    (void)start, (void)ends, (void)stop;
    Instance *it = c;
#ifdef RESETS
    *it = STARTS;
#endif
    it->real[TOLERANCE] = defined ? tolerance : -1.0;
    return fmi2OK;
}

#ifdef RESETS_LATE
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    *(Instance *)c = STARTS;
    return fmi2OK;
}
#endif

static void copy(Instance *it) {
    it->real[Y] = it->real[P];
    it->real[V] = it->real[U];
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    copy(c);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean keep) {
    (void)time, (void)step, (void)keep;
    copy(c);
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    *(Instance *)c = STARTS;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    for (size_t k = 0; k < n; k++) v[k] = ((Instance *)c)->real[r[k]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    for (size_t k = 0; k < n; k++) ((Instance *)c)->real[r[k]] = v[k];
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) {
    (void)r;
    for (size_t k = 0; k < n; k++) v[k] = ((Instance *)c)->whole;
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]) {
    (void)r;
    for (size_t k = 0; k < n; k++) ((Instance *)c)->whole = v[k];
    return fmi2OK;
}

size_t state_size = sizeof(Instance);
