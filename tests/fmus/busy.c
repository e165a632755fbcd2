/* An FMU of FMI 2.0 whose steps take `work` microseconds of the processor and make y = sin(gain (y + 1) + u) + u / 10.

   At its step number `at` it does what `trouble` says: nothing, a warning with a message, an error with one, a request
   for the end before the step or after it, or a NaN. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2Functions.h"

enum { U, Y, GAIN, WORK, AT, TROUBLE, REALS };
enum { NOTHING, WARN, FAIL, END_BEFORE, END_AFTER, NOT_A_NUMBER };

typedef struct {
    double real[REALS];
    int count;
    double reached;
    char *name;
    fmi2CallbackFunctions callbacks;
} Instance;

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type; (void)resources; (void)visible; (void)logging;
    Instance *instance = strcmp(guid, GUID) == 0 ? calloc(1, sizeof *instance) : NULL;
    if (instance) {
        instance->name = strdup(name);
        instance->callbacks = *callbacks;
    }
    return instance;
}

static void work(double microseconds) {
    struct timespec at, end;
    if (!(microseconds > 0.0)) return;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    end.tv_nsec += (long)(1e3 * microseconds);
    do {
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
    } while ((at.tv_sec - end.tv_sec) * 1000000000L + at.tv_nsec < end.tv_nsec);
}

static void say(Instance *instance, fmi2Status status, const char *text) {
    instance->callbacks.logger(instance->callbacks.componentEnvironment, instance->name, status, "", "%s", text);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    Instance *instance = component;
    double *real = instance->real;
    (void)no_return;
    work(real[WORK]);
    const int trouble = instance->count++ == (int)real[AT] ? (int)real[TROUBLE] : NOTHING;
    instance->reached = trouble == END_BEFORE ? time : time + step;
    if (trouble == FAIL) {
        say(instance, fmi2Error, "this step is refused");
        return fmi2Error;
    }
    if (trouble == END_BEFORE) return fmi2Discard;
    real[Y] = trouble == NOT_A_NUMBER ? NAN : sin(real[GAIN] * (real[Y] + 1.0) + real[U]) + 0.1 * real[U];
    if (trouble == WARN) {
        say(instance, fmi2Warning, "close to a limit");
        return fmi2Warning;
    }
    return trouble == END_AFTER ? fmi2Discard : fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value) {
    (void)component;
    *value = kind == fmi2Terminated;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value) {
    (void)kind;
    *value = ((Instance *)component)->reached;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) value[i] = ((Instance *)component)->real[vr[i] % REALS];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) ((Instance *)component)->real[vr[i] % REALS] = value[i];
    return fmi2OK;
}

void fmi2FreeInstance(fmi2Component component) {
    free(((Instance *)component)->name);
    free(component);
}
