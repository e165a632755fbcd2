/* A small FMU (FMI 2.0 co-simulation) whose whole future depends on its state: a filter of its inputs with noise.

   A step from t adds gain * u + offset, twice `number` where `flag` is set, and noise of a linear congruential generator
   (Numerical Recipes' constants) to the filter y, and counts. It sleeps `sleep` seconds in step `sleep_at`. Defined at
   compile time: MUTE, it cannot save its state; COMPLAINS, it says it can and fails. */

#define _POSIX_C_SOURCE 200809L
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2Functions.h"

enum { U, OFFSET, GAIN, Y, BEGAN, SLEEP, REALS };
enum { NUMBER, STEPS, SEED, SLEEP_AT, INTEGERS };
enum { FLAG, ODD, BOOLEANS };

typedef struct {
    double real[REALS];
    int integer[INTEGERS];
    int boolean[BOOLEANS];
    uint32_t generator;
} State;

typedef struct {
    State now;
    fmi2CallbackFunctions callbacks;
    char name[64];
} Instance;

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String s[]) {
    (void)c; (void)on; (void)n; (void)s;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type; (void)guid; (void)place; (void)visible; (void)logging;
    Instance *i = calloc(1, sizeof *i);
    i->callbacks = *callbacks;
    strncpy(i->name, name, sizeof i->name - 1);
    i->now.real[GAIN] = 1.0;
    i->now.integer[SEED] = 1;
    return i;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends,
                               fmi2Real stop) {
    (void)has; (void)tolerance; (void)ends; (void)stop;
    ((Instance *)c)->now.real[BEGAN] = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    State *s = &((Instance *)c)->now;
    s->generator = (uint32_t)s->integer[SEED];
    s->real[Y] = s->real[U]; /* so that a test sees what the inputs were */
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { (void)c; return fmi2Error; }

#define ACCESS(NAME, TYPE, FIELD)                                                                                     \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, TYPE v[]) {                      \
        for (size_t k = 0; k < n; k++) v[k] = ((Instance *)c)->now.FIELD[r[k]];                                        \
        return fmi2OK;                                                                                                \
    }                                                                                                                 \
    fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, const TYPE v[]) {                \
        for (size_t k = 0; k < n; k++) ((Instance *)c)->now.FIELD[r[k]] = v[k];                                        \
        return fmi2OK;                                                                                                \
    }
ACCESS(Real, fmi2Real, real)
ACCESS(Integer, fmi2Integer, integer)
ACCESS(Boolean, fmi2Boolean, boolean)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]) {
    (void)c; (void)r; (void)v;
    return n ? fmi2Error : fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]) {
    (void)c; (void)r; (void)v;
    return n ? fmi2Error : fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set) {
    State *s = &((Instance *)c)->now;
    (void)no_set;
    s->generator = 1664525u * s->generator + 1013904223u;
    double noise = s->generator / 4294967296.0 - 0.5;
    double in = s->real[GAIN] * s->real[U] + s->real[OFFSET] + (s->boolean[FLAG] ? 2.0 * s->integer[NUMBER] : 0.0);
    s->real[Y] = 0.7 * s->real[Y] + 0.1 * in + noise + step;
    s->real[BEGAN] = time;
    s->integer[STEPS]++;
    s->boolean[ODD] = s->integer[STEPS] % 3 == 1;
    if (s->integer[STEPS] == s->integer[SLEEP_AT]) {
        struct timespec wait = {(time_t)s->real[SLEEP], (long)(1e9 * (s->real[SLEEP] - (time_t)s->real[SLEEP]))};
        nanosleep(&wait, NULL);
    }
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) { (void)c; return fmi2Error; }

#define STATUS(NAME, TYPE)                                                                                            \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2StatusKind k, TYPE *v) {                                       \
        (void)c; (void)k; (void)v;                                                                                    \
        return fmi2Discard;                                                                                           \
    }
STATUS(Status, fmi2Status)
STATUS(RealStatus, fmi2Real)
STATUS(IntegerStatus, fmi2Integer)
STATUS(BooleanStatus, fmi2Boolean)
STATUS(StringStatus, fmi2String)

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
                                       const fmi2Real v[]) {
    (void)c; (void)r; (void)n; (void)o; (void)v;
    return fmi2Error;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
                                        fmi2Real v[]) {
    (void)c; (void)r; (void)n; (void)o; (void)v;
    return fmi2Error;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t n,
                                        const fmi2ValueReference k[], size_t m, const fmi2Real d[], fmi2Real v[]) {
    (void)c; (void)u; (void)n; (void)k; (void)m; (void)d; (void)v;
    return fmi2Error;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
#ifdef MUTE
    (void)c; (void)state;
    return fmi2Error;
#else
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &((Instance *)c)->now, sizeof(State));
    return fmi2OK;
#endif
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    memcpy(&((Instance *)c)->now, state, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c; (void)state;
    *size = sizeof(State);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
#ifdef COMPLAINS
    Instance *i = c;
    (void)state; (void)bytes; (void)size;
    i->callbacks.logger(i->callbacks.componentEnvironment, i->name, fmi2Error, "logStatusError", "no room for it");
    return fmi2Error;
#else
    (void)c;
    memcpy(bytes, state, size);
    return fmi2OK;
#endif
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    (void)c;
    if (size != sizeof(State)) return fmi2Error;
    *state = malloc(sizeof(State));
    memcpy(*state, bytes, size);
    return fmi2OK;
}
