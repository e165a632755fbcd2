/* FMI 1.0 co-simulation around the model. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi1Functions.h"
#include "model.h"

#define JOINED(A, B) A##_##B
#define NAMED(A, B) JOINED(A, B)
#define F(NAME) NAMED(IDENTIFIER, fmi##NAME)
#define FMI(NAME) fmi1##NAME

typedef struct {
    State state;
    fmi1CallbackFunctions callbacks;
    char name[256];
} Instance;

static fmi1Status say(Instance *it, fmi1Status status, const char *text) {
    it->callbacks.logger(it, it->name, status, "error", "%s", text);
    return status;
}

const char *F(GetTypesPlatform)(void) { return "standard32"; }
const char *F(GetVersion)(void) { return "1.0"; }

fmi1Component F(InstantiateSlave)(fmi1String name, fmi1String token, fmi1String location, fmi1String mime,
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

void F(FreeSlaveInstance)(fmi1Component c) { free(c); }

fmi1Status F(InitializeSlave)(fmi1Component c, fmi1Real start, fmi1Boolean defined, fmi1Real stop) {
    (void)defined; (void)stop;
    ((Instance *)c)->state.time = start;
    model_initialise(&((Instance *)c)->state);
    return fmi1OK;
}

fmi1Status F(TerminateSlave)(fmi1Component c) { return say(c, fmi1Warning, "terminated"); }

fmi1Status F(ResetSlave)(fmi1Component c) {
    ((Instance *)c)->state = (State){.values = DEFAULTS};
    return fmi1OK;
}

fmi1Status F(DoStep)(fmi1Component c, fmi1Real time, fmi1Real step, fmi1Boolean new) {
    (void)new;
    Instance *it = c;
    const char *message = "";
    Outcome outcome = model_advance(&it->state, time, step, &message);
    if (outcome >= RAW - 10) return (fmi1Status)(outcome - RAW);
    if (outcome == FAILED) return say(it, fmi1Error, message);
    if (outcome == BROKEN) return say(it, fmi1Fatal, message);
    return outcome == DONE ? fmi1OK : fmi1Discard;
}

#include "scalars.h"

/* What FMI asks for and these models do not have. */
#define REFUSE(NAME) fmi1Status F(NAME)(fmi1Component c) { return say(c, fmi1Error, "not implemented"); }
REFUSE(SetDebugLogging) REFUSE(SetRealInputDerivatives)
REFUSE(GetRealOutputDerivatives) REFUSE(CancelStep) REFUSE(GetStatus) REFUSE(GetRealStatus)
REFUSE(GetIntegerStatus) REFUSE(GetBooleanStatus) REFUSE(GetStringStatus)
