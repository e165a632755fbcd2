/* An FMU (FMI 2.0 co-simulation) with all types of inputs, outputs and parameters, whose outputs depend on the past, on
   time and on the length of its steps. Reals: inputs 0 to 2, outputs 10 to 12, parameters 20 gain, 21 trim (tunable),
   22 fail_at, 23 end_at, 24 nan_at [s], 25 fatal_at; below 0: never. Integer input 0, output 10; Boolean input 0, output 10; String
   parameter 0, output 10. With the label "talk" it logs. Its memory is the host's. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fmi2Functions.h"

typedef struct {
    double u[3], y[3], p[6], x, reached;
    int k, n, b, flag, steps, ended;
    unsigned noise;
    char label[40], text[60];
} State;

typedef struct {
    const fmi2CallbackFunctions *host;
    char name[100];
    State state;
} Instance;

static const State start = {.p = {0.5, 0.0, -1.0, -1.0, -1.0, -1.0}, .noise = 1, .label = "cell"};

static double draw(State *s) {
    s->noise = s->noise * 1664525u + 1013904223u;
    return (double)s->noise / 4294967296.0 - 0.5;
}

static void show(State *s, double time) {
    s->y[0] = s->x + s->p[1];
    s->y[1] = s->u[1] - 0.25 * s->x;
    s->y[2] = s->p[4] >= 0.0 && time >= s->p[4] ? NAN : sin(time) + s->u[2];
    s->n = s->k + s->steps % 7;
    s->flag = s->b ^ (s->x > 0.0);
    snprintf(s->text, sizeof s->text, "%s %d", s->label, s->steps);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)visible; (void)logging;
    if (type != fmi2CoSimulation || strcmp(guid, GUID) || strncmp(resources, "file:", 5)) return NULL;
    Instance *c = callbacks->allocateMemory(1, sizeof *c);
    if (c) {
        c->host = callbacks;
        snprintf(c->name, sizeof c->name, "%s", name);
        c->state = start;
    }
    return c;
}

void fmi2FreeInstance(fmi2Component c) { if (c) ((Instance *)c)->host->freeMemory(c); }

fmi2Status fmi2Reset(fmi2Component c) {
    ((Instance *)c)->state = start;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    State *s = &((Instance *)c)->state;
    s->x = 0.1 * s->u[0] + 0.01 * s->k;
    show(s, 0.0);
    return fmi2OK;
}

static void talk(Instance *c, fmi2Status status, const char *format, double value) {
    c->host->logger(c->host->componentEnvironment, c->name, status, "events", format, value);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    Instance *c = component;
    State *s = &c->state;
    (void)no_return;
    if (s->p[5] >= 0.0 && time >= s->p[5] - 1e-9) {
        talk(c, fmi2Fatal, "is lost at %g s", time);
        return fmi2Fatal;
    }
    if (s->p[2] >= 0.0 && time >= s->p[2] - 1e-9) {
        talk(c, fmi2Error, "fails at 100%% of #r10# and %g s", time);
        return fmi2Error;
    }
    s->x = s->x * (1.0 - 3.0 * step) + step * (s->p[0] * s->u[0] + draw(s)) + 1e-3 * s->u[1] * time;
    s->steps++;
    s->reached = time + step;
    show(s, time + step);
    if (!strcmp(s->label, "talk") && s->steps == 3) talk(c, fmi2Warning, "x is %.3f, 50%% of it", s->x);
    if (s->p[3] >= 0.0 && time + step >= s->p[3] - 1e-9) {
        s->ended = 1;
        return fmi2Discard;
    }
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = ((Instance *)c)->state.ended;
    return kind == fmi2Terminated ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    *value = ((Instance *)c)->state.reached;
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}

static double *real(State *s, fmi2ValueReference vr) {
    return vr < 3 ? &s->u[vr] : vr < 10 ? NULL : vr < 13 ? &s->y[vr - 10] : vr >= 20 && vr < 26 ? &s->p[vr - 20] : NULL;
}

#define EACH(ACTION) for (size_t i = 0; i < n; i++) { ACTION; } return fmi2OK;
#define S (&((Instance *)c)->state)

static fmi2Status initial(fmi2Component c) { show(S, 0.0); return fmi2OK; }

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return initial(c); }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    EACH(double *at = real(S, vr[i]); if (!at) return fmi2Error; value[i] = *at)
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    EACH(double *at = real(S, vr[i]); if (!at || (vr[i] >= 10 && vr[i] < 20)) return fmi2Error; *at = value[i])
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    EACH(value[i] = vr[i] ? S->n : S->k)
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    EACH(if (vr[i]) return fmi2Error; S->k = value[i])
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    EACH(value[i] = vr[i] ? S->flag : S->b)
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    EACH(if (vr[i]) return fmi2Error; S->b = value[i])
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    EACH(value[i] = vr[i] ? S->text : S->label)
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    EACH(if (vr[i]) return fmi2Error; snprintf(S->label, sizeof S->label, "%s", value[i]))
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = ((Instance *)c)->host->allocateMemory(1, sizeof(State));
    memcpy(*state, S, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    memcpy(S, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (*state) ((Instance *)c)->host->freeMemory(*state);
    *state = NULL;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c; (void)state;
    *size = sizeof(State);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    (void)c;
    if (size < sizeof(State)) return fmi2Error;
    memcpy(bytes, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    if (size != sizeof(State)) return fmi2Error;
    *state = ((Instance *)c)->host->allocateMemory(1, size);
    memcpy(*state, bytes, size);
    return fmi2OK;
}
