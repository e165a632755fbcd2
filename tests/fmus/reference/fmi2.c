/* FMI 2.0 co-simulation around the model, with a state that can be saved. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "model.h"

#define FMI(NAME) fmi2##NAME
#define F FMI

typedef struct {
    State state;
    const fmi2CallbackFunctions *callbacks;
    char name[256];
    bool stepping, ended;
    double reached;
} Instance;

static fmi2Status say(Instance *it, fmi2Status status, const char *text) {
    it->callbacks->logger(it->callbacks->componentEnvironment, it->name, status, "logStatusError", "%s", text);
    return status;
}

/* Turn file:///a%20b into /a b. */
static void decoded(const char *uri, char *path, size_t size) {
    if (!strncmp(uri, "file://", 7)) uri += 7;
    size_t n = 0;
    for (unsigned byte; *uri && n + 1 < size; n++) {
        if (*uri == '%' && sscanf(uri + 1, "%2x", &byte) == 1) {
            path[n] = (char)byte;
            uri += 3;
        } else {
            path[n] = *uri++;
        }
    }
    path[n] = 0;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)visible; (void)logging;
    char path[4096];
    Instance *it = calloc(1, sizeof(Instance));
    it->callbacks = callbacks;
    it->state.values = DEFAULTS;
    snprintf(it->name, sizeof it->name, "%s", name);
    decoded(resources, path, sizeof path);
    const char *wrong = type != fmi2CoSimulation || strcmp(token, TOKEN) ? "wrong GUID" : model_open(&it->state, path);
    if (!wrong) return it;
    say(it, fmi2Error, wrong);
    free(it);
    return NULL;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean t, fmi2Real tolerance, fmi2Real start, fmi2Boolean s,
                               fmi2Real stop) {
    (void)t; (void)tolerance; (void)s; (void)stop;
    ((Instance *)c)->state.time = start;
    return fmi2OK;
}

#include "modes.h"

fmi2Status fmi2Reset(fmi2Component c) {
    Instance *it = c;
    it->state = (State){.values = DEFAULTS};
    it->stepping = it->ended = false;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set) {
    (void)no_set;
    Instance *it = c;
    const char *message = "";
    Outcome outcome = model_advance(&it->state, time, step, &message);
    if (outcome >= RAW - 10) return (fmi2Status)(outcome - RAW);
    if (outcome == FAILED) return say(it, fmi2Error, message);
    if (outcome == BROKEN) return say(it, fmi2Fatal, message);
    it->ended = outcome == END || outcome == LAST;
    it->reached = outcome == LAST ? time + step : time;
    return outcome == DONE ? fmi2OK : fmi2Discard;
}

#include "scalars.h"

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = ((Instance *)c)->ended;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((Instance *)c)->reached;
    return fmi2OK;
}

size_t state_size = sizeof(State);

fmi2Status refused(fmi2Component c) { return say(c, fmi2Error, "this function is not implemented"); }
