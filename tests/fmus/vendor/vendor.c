/* A foreign attitude controller (FMI 2.0 co-simulation), in other conventions than those of flexsat.

   Inputs: scalar-first quaternion that takes body to inertial components, rate in deg/s, an integer validity flag
   (3 is valid), a mode (it commands nothing but in mode 2), wheel speeds in rpm, which it only reports on.
   Outputs: wheel torque in mN.m, a status word. All arrays count from 0, the step is 10 ms and no other, and there
   is one instance in the life of a process. */

#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "law.h"

enum { Q = 0, OMEGA = 4, SPEED = 7, TORQUE = 13, KP = 19, KD = 20, LIMIT = 21, REALS = 22 };
enum { VALID, MODE, STATUS, INTEGERS };

static int instances;

typedef struct {
    fmi2CallbackFunctions callbacks;
    fmi2String name;
    double real[REALS];
    int integer[INTEGERS];
    double angle[3]; /* the last valid attitude, body from inertial [rad] */
} Instance;

static fmi2Status say(Instance *instance, const char *text) {
    instance->callbacks.logger(instance->callbacks.componentEnvironment, instance->name, fmi2Error, "logStatusError",
                               "%s", text);
    return fmi2Error;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources; (void)visible; (void)logging;
    if (type != fmi2CoSimulation || strcmp(guid, GUID) != 0 || instances++) return NULL;
    Instance *it = calloc(1, sizeof(Instance));
    it->callbacks = *callbacks;
    it->name = strdup(name);
    it->real[Q] = 1;
    it->real[KP] = 0.02;
    it->real[KD] = 0.2;
    it->real[LIMIT] = 4400;
    return it;
}

void fmi2FreeInstance(fmi2Component c) {
    free((void *)((Instance *)c)->name);
    free(c);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set) {
    (void)time; (void)no_set;
    if (fabs(step - STEP) > 1e-9) return say(c, "the step must be 10 ms");
    Instance *it = c;
    Gains gains = {it->real[KP], it->real[KD], it->real[LIMIT]};
    control(&gains, it->real + Q, it->real + OMEGA, it->integer[VALID], it->integer[MODE], it->angle, it->real + TORQUE);
    it->integer[STATUS]++;
    return fmi2OK;
}

#define ACCESS(NAME, TYPE, FIELD, COUNT)                                                                              \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, TYPE v[]) {                     \
        for (size_t k = 0; k < n; k++) {                                                                              \
            if (r[k] >= COUNT) return say(c, "no such value reference");                                              \
            v[k] = ((Instance *)c)->FIELD[r[k]];                                                                      \
        }                                                                                                             \
        return fmi2OK;                                                                                                \
    }                                                                                                                 \
    fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, const TYPE v[]) {               \
        for (size_t k = 0; k < n; k++) {                                                                              \
            if (r[k] >= COUNT) return say(c, "no such value reference");                                              \
            ((Instance *)c)->FIELD[r[k]] = v[k];                                                                      \
        }                                                                                                             \
        return fmi2OK;                                                                                                \
    }

ACCESS(Real, fmi2Real, real, REALS)
ACCESS(Integer, fmi2Integer, integer, INTEGERS)

fmi2Status refused(fmi2Component c) { return say(c, "this function is not implemented"); }
