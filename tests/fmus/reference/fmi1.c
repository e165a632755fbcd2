/* FMI 1.0 co-simulation around the model. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi1Functions.h"
#include "model.h"

#define JOINED(A, B) A##_##B
#define NAMED(A, B) JOINED(A, B)
#define F(NAME) NAMED(IDENTIFIER, NAME)

typedef struct {
    State state;
    fmi1CallbackFunctions callbacks;
    char name[256];
} Instance;

static fmi1Status say(Instance *it, fmi1Status status, const char *text) {
    it->callbacks.logger(it, it->name, status, "error", "%s", text);
    return status;
}

const char *F(fmiGetTypesPlatform)(void) { return "standard32"; }
const char *F(fmiGetVersion)(void) { return "1.0"; }

fmi1Component F(fmiInstantiateSlave)(fmi1String name, fmi1String token, fmi1String location, fmi1String mime,
                                     fmi1Real timeout, fmi1Boolean visible, fmi1Boolean interactive,
                                     fmi1CallbackFunctions callbacks, fmi1Boolean logging) {
    (void)location; (void)mime; (void)timeout; (void)visible; (void)interactive; (void)logging;
    Instance *it = calloc(1, sizeof(Instance));
    it->callbacks = callbacks;
    it->state.values = DEFAULTS;
    snprintf(it->name, sizeof it->name, "%s", name);
    if (!strcmp(token, TOKEN)) return it;
    say(it, fmi1Error, "wrong GUID");
    free(it);
    return NULL;
}

void F(fmiFreeSlaveInstance)(fmi1Component c) { free(c); }

fmi1Status F(fmiInitializeSlave)(fmi1Component c, fmi1Real start, fmi1Boolean defined, fmi1Real stop) {
    (void)defined; (void)stop;
    ((Instance *)c)->state.time = start;
    model_initialise(&((Instance *)c)->state);
    return fmi1OK;
}

fmi1Status F(fmiTerminateSlave)(fmi1Component c) { return say(c, fmi1Warning, "terminated"); }

fmi1Status F(fmiDoStep)(fmi1Component c, fmi1Real time, fmi1Real step, fmi1Boolean new) {
    (void)new;
    Instance *it = c;
    const char *message = "";
    it->state.time = time;
    Outcome outcome = model_step(&it->state, step, &message);
    it->state.steps++;
    if (outcome == FAILED) return say(it, fmi1Error, message);
    if (outcome == BROKEN) return say(it, fmi1Fatal, message);
    return outcome == DONE ? fmi1OK : fmi1Discard;
}

#define ACCESS(NAME, TYPE, KIND)                                                                                      \
    fmi1Status F(fmiGet##NAME)(fmi1Component c, const fmi1ValueReference r[], size_t n, TYPE v[]) {                   \
        for (size_t k = 0; k < n; k++) {                                                                              \
            if (r[k] >= COUNT || VARIABLES[r[k]].kind != KIND) return say(c, fmi1Error, "no such variable");          \
            v[k] = *(TYPE *)((char *)&((Instance *)c)->state.values + VARIABLES[r[k]].offset);                        \
        }                                                                                                             \
        return fmi1OK;                                                                                                \
    }                                                                                                                 \
    fmi1Status F(fmiSet##NAME)(fmi1Component c, const fmi1ValueReference r[], size_t n, const TYPE v[]) {             \
        for (size_t k = 0; k < n; k++) {                                                                              \
            if (r[k] >= COUNT || VARIABLES[r[k]].kind != KIND) return say(c, fmi1Error, "no such variable");          \
            *(TYPE *)((char *)&((Instance *)c)->state.values + VARIABLES[r[k]].offset) = v[k];                        \
        }                                                                                                             \
        return fmi1OK;                                                                                                \
    }

ACCESS(Real, fmi1Real, FLOAT64)
ACCESS(Integer, fmi1Integer, INT32)
ACCESS(Boolean, fmi1Boolean, BOOLEAN)

fmi1Status F(fmiGetString)(fmi1Component c, const fmi1ValueReference r[], size_t n, fmi1String v[]) {
    for (size_t k = 0; k < n; k++) {
        if (r[k] >= COUNT || VARIABLES[r[k]].kind != STRING) return say(c, fmi1Error, "no such variable");
        v[k] = (char *)&((Instance *)c)->state.values + VARIABLES[r[k]].offset;
    }
    return fmi1OK;
}

fmi1Status F(fmiSetString)(fmi1Component c, const fmi1ValueReference r[], size_t n, const fmi1String v[]) {
    for (size_t k = 0; k < n; k++) {
        if (r[k] >= COUNT || VARIABLES[r[k]].kind != STRING) return say(c, fmi1Error, "no such variable");
        if (strlen(v[k]) >= TEXT) return say(c, fmi1Error, "the text is too long");
        strcpy((char *)&((Instance *)c)->state.values + VARIABLES[r[k]].offset, v[k]);
    }
    return fmi1OK;
}

/* What FMI asks for and these models do not have. */
#define REFUSE(NAME) fmi1Status F(NAME)(fmi1Component c) { return say(c, fmi1Error, "not implemented"); }
REFUSE(fmiSetDebugLogging) REFUSE(fmiResetSlave) REFUSE(fmiSetRealInputDerivatives)
REFUSE(fmiGetRealOutputDerivatives) REFUSE(fmiCancelStep) REFUSE(fmiGetStatus) REFUSE(fmiGetRealStatus)
REFUSE(fmiGetIntegerStatus) REFUSE(fmiGetBooleanStatus) REFUSE(fmiGetStringStatus)
