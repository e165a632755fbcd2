/* An FMU (FMI 2.0 co-simulation) that gives its inputs back as outputs at the end of a step, with value references 10
   higher: Reals 0 and 1, Integer 0, Boolean 0, String 0. Parameter 30 and the local Real 31, three times input 0. Output
   11 is not a number while the Integer is 9; 7 sends the process a SIGINT at the end of the initialization. The whole state is one block of memory. */

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

typedef struct {
    double x[2], out[2], inner;
    int n, b, out_n, out_b;
    char s[100], out_s[100];
} Instance;

static void copy(Instance *m) {
    memcpy(m->out, m->x, sizeof m->x);
    if (m->n == 9) m->out[1] = NAN;
    m->inner = 3.0 * m->x[0];
    m->out_n = m->n;
    m->out_b = m->b;
    memcpy(m->out_s, m->s, sizeof m->s);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name; (void)resources; (void)callbacks; (void)visible; (void)logging;
    return type == fmi2CoSimulation && strcmp(guid, GUID) == 0 ? calloc(1, sizeof(Instance)) : NULL;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    copy(c);
    if (((Instance *)c)->n == 7) raise(SIGINT);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    (void)time; (void)step; (void)no_return;
    copy(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Instance *m = c;
    for (size_t i = 0; i < n; i++)
        value[i] = vr[i] == 30 ? 3.0 : vr[i] == 31 ? m->inner : vr[i] >= 10 ? m->out[vr[i] - 10] : m->x[vr[i]];
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    Instance *m = c;
    for (size_t i = 0; i < n; i++) value[i] = vr[i] >= 10 ? m->out_n : m->n;
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    Instance *m = c;
    for (size_t i = 0; i < n; i++) value[i] = vr[i] >= 10 ? m->out_b : m->b;
    return fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    Instance *m = c;
    for (size_t i = 0; i < n; i++) value[i] = vr[i] >= 10 ? m->out_s : m->s;
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    for (size_t i = 0; i < n; i++)
        if (vr[i] < 2) ((Instance *)c)->x[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    (void)vr;
    for (size_t i = 0; i < n; i++) ((Instance *)c)->n = value[i];
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    (void)vr;
    for (size_t i = 0; i < n; i++) ((Instance *)c)->b = value[i];
    return fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)vr;
    for (size_t i = 0; i < n; i++) snprintf(((Instance *)c)->s, 100, "%s", value[i]);
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(Instance));
    memcpy(*state, c, sizeof(Instance));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { memcpy(c, state, sizeof(Instance)); return fmi2OK; }

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c; (void)state;
    *size = sizeof(Instance);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    (void)c;
    memcpy(bytes, state, size);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    (void)c;
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return fmi2OK;
}
