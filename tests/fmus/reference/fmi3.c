/* FMI 3.0 co-simulation around the model: no event mode, no early return, state that can be saved. */

#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"
#include "model.h"

#define FMI(NAME) fmi3##NAME

typedef struct {
    State state;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    bool stepping;
    fmi3String texts[COUNT * 8]; /* what a call handed out */
} Instance;

static fmi3Status say(Instance *it, fmi3Status status, const char *text) {
    if (it->log) it->log(it->environment, status, "logStatusError", text);
    return status;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name; (void)visible; (void)logging; (void)required; (void)count; (void)update;
    Instance *it = calloc(1, sizeof(Instance));
    it->log = log;
    it->environment = environment;
    it->state.values = DEFAULTS;
    const char *wrong = strcmp(token, TOKEN) ? "wrong instantiation token"
                        : events || early   ? "event mode and early return are not for this model"
                                            : model_open(&it->state, resources);
    if (!wrong) return it;
    say(it, fmi3Error, wrong);
    free(it);
    return NULL;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean t, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean s, fmi3Float64 stop) {
    (void)t; (void)tolerance; (void)s; (void)stop;
    ((Instance *)c)->state.time = start;
    return fmi3OK;
}

#include "modes.h"

fmi3Status fmi3Reset(fmi3Instance c) {
    Instance *it = c;
    it->state = (State){.values = DEFAULTS};
    it->stepping = false;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_set;
    Instance *it = c;
    const char *message = "";
    *event = *end = *early = false;
    Outcome outcome = model_advance(&it->state, time, step, &message);
    *reached = outcome == EARLY ? time + step / 2 : outcome == END ? time : time + step;
    if (outcome >= RAW - 10) return (fmi3Status)(outcome - RAW);
    if (outcome == FAILED) return say(it, fmi3Error, message);
    if (outcome == BROKEN) return say(it, fmi3Fatal, message);
    *event = outcome == EVENT;
    *end = outcome == END || outcome == LAST;
    *early = outcome == EARLY;
    return fmi3OK;
}

#define ACCESS(NAME, TYPE, KIND)                                                                                      \
    fmi3Status fmi3Get##NAME(fmi3Instance c, const fmi3ValueReference r[], size_t n, TYPE v[], size_t total) {        \
        size_t at = 0;                                                                                                \
        for (size_t k = 0; k < n; at += VARIABLES[r[k++]].count) {                                                    \
            const void *from = model_value(&((Instance *)c)->state, r[k], KIND);                                      \
            if (!from) return say(c, fmi3Error, "no such variable");                                                  \
            if (at + VARIABLES[r[k]].count > total) return say(c, fmi3Error, "too few values");                       \
            memcpy(v + at, from, VARIABLES[r[k]].count * sizeof(TYPE));                                               \
        }                                                                                                             \
        return at == total ? fmi3OK : say(c, fmi3Error, "too many values");                                           \
    }                                                                                                                 \
    fmi3Status fmi3Set##NAME(fmi3Instance c, const fmi3ValueReference r[], size_t n, const TYPE v[], size_t total) {  \
        size_t at = 0;                                                                                                \
        for (size_t k = 0; k < n; at += VARIABLES[r[k++]].count) {                                                    \
            void *to = model_value(&((Instance *)c)->state, r[k], KIND);                                              \
            if (!to) return say(c, fmi3Error, "no such variable");                                                    \
            if (at + VARIABLES[r[k]].count > total) return say(c, fmi3Error, "too few values");                       \
            memcpy(to, v + at, VARIABLES[r[k]].count * sizeof(TYPE));                                                 \
        }                                                                                                             \
        return at == total ? fmi3OK : say(c, fmi3Error, "too many values");                                           \
    }

ACCESS(Float32, fmi3Float32, FLOAT32)
ACCESS(Float64, fmi3Float64, FLOAT64)
ACCESS(Int8, fmi3Int8, INT8)
ACCESS(Int16, fmi3Int16, INT16)
ACCESS(Int32, fmi3Int32, INT32)
ACCESS(Int64, fmi3Int64, INT64)
ACCESS(UInt8, fmi3UInt8, UINT8)
ACCESS(UInt16, fmi3UInt16, UINT16)
ACCESS(UInt32, fmi3UInt32, UINT32)
ACCESS(UInt64, fmi3UInt64, UINT64)
ACCESS(Boolean, fmi3Boolean, BOOLEAN)

fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3String v[], size_t total) {
    size_t at = 0;
    for (size_t k = 0; k < n; k++) {
        Text *from = model_value(&((Instance *)c)->state, r[k], STRING);
        if (!from) return say(c, fmi3Error, "no such variable");
        for (size_t e = 0; e < VARIABLES[r[k]].count && at < total; e++) v[at++] = from[e];
    }
    return at == total ? fmi3OK : say(c, fmi3Error, "too many values");
}

fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3String v[], size_t total) {
    size_t at = 0;
    for (size_t k = 0; k < n; k++) {
        Text *to = model_value(&((Instance *)c)->state, r[k], STRING);
        if (!to) return say(c, fmi3Error, "no such variable");
        for (size_t e = 0; e < VARIABLES[r[k]].count && at < total; e++, at++) {
            if (strlen(v[at]) >= TEXT) return say(c, fmi3Error, "the text is too long");
            strcpy(to[e], v[at]);
        }
    }
    return at == total ? fmi3OK : say(c, fmi3Error, "too many values");
}

size_t state_size = sizeof(State);

fmi3Status refused(fmi3Instance c) { return say(c, fmi3Error, "this function is not implemented"); }
