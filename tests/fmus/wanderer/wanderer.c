/* A small FMU (FMI 2.0 co-simulation) whose whole future depends on its state: a filter of its inputs with noise.

   A step from t adds gain * u + offset, twice `number` where `flag` is set, and noise of a linear congruential generator
   (Numerical Recipes' constants) to the filter y, and counts. It sleeps `sleep` seconds in step `sleep_at`, or in
   each step if that is -1. Defined at compile time: MUTE, it cannot save its state; COMPLAINS, it says it can and fails;
   CRASHES, it does so in its fifth step with a gain below 0; RESETS, it can be reset; FORGETS, it says so, and
   keeps the number of its steps; RESEEDS, its seed is tunable, and begins the noise anew. */

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
#ifdef RESEEDS
    int begun; /* seed that the noise began with */
#endif
} State;

typedef struct {
    State now;
    fmi2CallbackFunctions callbacks;
    char name[64];
} Instance;

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

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends,
                               fmi2Real stop) {
    (void)has; (void)tolerance; (void)ends; (void)stop;
    ((Instance *)c)->now.real[BEGAN] = start;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    State *s = &((Instance *)c)->now;
    s->generator = (uint32_t)s->integer[SEED];
    s->real[Y] = s->real[U]; /* so that a test sees what the inputs were */
    return fmi2OK;
}

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

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set) {
    State *s = &((Instance *)c)->now;
    (void)no_set;
#ifdef CRASHES
    if (s->integer[STEPS] == 4 && s->real[GAIN] < 0.0) abort();
#endif
#ifdef RESEEDS
    if (s->integer[SEED] != s->begun) s->generator = (uint32_t)(s->begun = s->integer[SEED]);
#endif
    s->generator = 1664525u * s->generator + 1013904223u;
    double noise = s->generator / 4294967296.0 - 0.5;
    double in = s->real[GAIN] * s->real[U] + s->real[OFFSET] + (s->boolean[FLAG] ? 2.0 * s->integer[NUMBER] : 0.0);
    s->real[Y] = 0.7 * s->real[Y] + 0.1 * in + noise + step;
    s->real[BEGAN] = time;
    s->integer[STEPS]++;
    s->boolean[ODD] = s->integer[STEPS] % 3 == 1;
    if (s->integer[SLEEP_AT] == -1 || s->integer[STEPS] == s->integer[SLEEP_AT]) {
        struct timespec wait = {(time_t)s->real[SLEEP], (long)(1e9 * (s->real[SLEEP] - (time_t)s->real[SLEEP]))};
        nanosleep(&wait, NULL);
    }
    return fmi2OK;
}

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

#if defined RESETS || defined FORGETS
fmi2Status fmi2Reset(fmi2Component c) {
    State *s = &((Instance *)c)->now;
    State fresh = {.real[GAIN] = 1.0, .integer[SEED] = 1};
#ifdef FORGETS
    fresh.integer[STEPS] = s->integer[STEPS];
#endif
    *s = fresh;
    return fmi2OK;
}
#endif

#ifndef MUTE
size_t state_size = sizeof(State);
#endif

#ifdef COMPLAINS
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    Instance *i = c;
    (void)state; (void)bytes; (void)size;
    i->callbacks.logger(i->callbacks.componentEnvironment, i->name, fmi2Error, "logStatusError", "no room for it");
    return fmi2Error;
}
#endif
