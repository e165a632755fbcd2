/* The same foreign controller as FMI 3.0: true arrays, rates in single precision, an 8-bit validity flag, an unsigned
   mode, a 64-bit status word. Its step is 10 ms and no other, and there is one instance in the life of a process. */

#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"
#include "law.h"

enum { Q, RATE, SPEED, TORQUE, KP, KD, LIMIT, VALID, MODE, STATUS };

static int instances;

typedef struct {
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    fmi3Float64 q[4], speed[WHEELS], torque[WHEELS];
    fmi3Float32 rate[3];
    Gains gains;
    fmi3Int8 valid;
    fmi3UInt8 mode;
    fmi3UInt64 status;
    double angle[3];
} Instance;

static fmi3Status say(Instance *it, const char *text) {
    it->log(it->environment, fmi3Error, "logStatusError", text);
    return fmi3Error;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name; (void)resources; (void)visible; (void)logging; (void)required; (void)count; (void)update;
    if (events || early || strcmp(token, TOKEN) != 0 || instances++) return NULL;
    Instance *it = calloc(1, sizeof(Instance));
    it->log = log;
    it->environment = environment;
    it->q[0] = 1;
    it->gains = (Gains){0.02, 0.2, 4400};
    return it;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_set;
    Instance *it = c;
    double rate[3] = {it->rate[0], it->rate[1], it->rate[2]};
    *event = *end = *early = fmi3False;
    *reached = time + step;
    if (fabs(step - STEP) > 1e-9) return say(it, "the step must be 10 ms");
    control(&it->gains, it->q, rate, it->valid, it->mode, it->angle, it->torque);
    it->status++;
    return fmi3OK;
}

static void *place(Instance *it, fmi3ValueReference reference, size_t *count) {
    static const size_t COUNTS[] = {4, 3, WHEELS, WHEELS, 1, 1, 1, 1, 1, 1};
    void *places[] = {it->q, it->rate, it->speed, it->torque, &it->gains.kp, &it->gains.kd, &it->gains.limit,
                      &it->valid, &it->mode, &it->status};
    *count = reference <= STATUS ? COUNTS[reference] : 0;
    return reference <= STATUS ? places[reference] : NULL;
}

#define ACCESS(NAME, TYPE, ALLOWED)                                                                                   \
    fmi3Status fmi3Get##NAME(fmi3Instance c, const fmi3ValueReference r[], size_t n, TYPE v[], size_t total) {        \
        size_t at = 0, count;                                                                                         \
        for (size_t k = 0; k < n; k++, at += count) {                                                                 \
            const void *from = place(c, r[k], &count);                                                                \
            if (!from || !(ALLOWED) || at + count > total) return say(c, "no such variable, or too few values");      \
            memcpy(v + at, from, count * sizeof(TYPE));                                                               \
        }                                                                                                             \
        return at == total ? fmi3OK : say(c, "too many values");                                                      \
    }                                                                                                                 \
    fmi3Status fmi3Set##NAME(fmi3Instance c, const fmi3ValueReference r[], size_t n, const TYPE v[], size_t total) {  \
        size_t at = 0, count;                                                                                         \
        for (size_t k = 0; k < n; k++, at += count) {                                                                 \
            void *to = place(c, r[k], &count);                                                                        \
            if (!to || !(ALLOWED) || at + count > total) return say(c, "no such variable, or too few values");        \
            memcpy(to, v + at, count * sizeof(TYPE));                                                                 \
        }                                                                                                             \
        return at == total ? fmi3OK : say(c, "too many values");                                                      \
    }

ACCESS(Float64, fmi3Float64, r[k] < VALID && r[k] != RATE)
ACCESS(Float32, fmi3Float32, r[k] == RATE)
ACCESS(Int8, fmi3Int8, r[k] == VALID)
ACCESS(UInt8, fmi3UInt8, r[k] == MODE)
ACCESS(UInt64, fmi3UInt64, r[k] == STATUS)

fmi3Status refused(fmi3Instance c) { return say(c, "this function is not implemented"); }
