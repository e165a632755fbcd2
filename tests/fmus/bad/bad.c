/* A small sampled FMU (FMI 2.0 co-simulation), good unless one DEFECT_... is defined.

   Inputs level and rate are read at the beginning of a step; output scaled = gain * level + noise holds from there,
   output filtered is the filter before the new sample of rate enters it (so it answers one step later), count counts
   the steps. The noise is a linear congruential generator (Numerical Recipes' constants), seeded at start. */

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "fmi2Functions.h"

#include "processes.h"

#define STEP 0.01
#define REALS 5 /* level, rate, gain, scaled, filtered */
#define HISTORY 8

enum { LEVEL, RATE, GAIN, SCALED, FILTERED };

typedef struct {
    double real[REALS];
    int count;
    double history[HISTORY];
    uint32_t generator;
    int failed;
} Moving;

typedef struct {
    Moving now; /* the state begins the instance */
    char *name;
    fmi2CallbackFunctions callbacks;
    int logging;
    double *array; /* outside the state with DEFECT_HIDDEN_ARRAY */
} Instance;

#ifdef DEFECT_SHARED_BETWEEN_INSTANCES
static double filter; /* one for all; saving and setting a state know of it */
#define FILTER filter
#else
#define FILTER instance->now.history[0]
#endif

#ifdef DEFECT_LEAKS
static void *volatile leaked;
#endif

static void say(Instance *instance, fmi2Status status, const char *text) {
#ifdef DEFECT_SILENT_ERRORS
    (void)instance; (void)status; (void)text;
#else
    const char *category = "logStatusError";
    const char *name = instance->name;
#ifdef DEFECT_UNDECLARED_CATEGORY
    category = "panic";
#endif
#ifdef DEFECT_LOGS_ANOTHER_NAME
    name = "somebody";
#endif
    if (instance->logging) {
        instance->callbacks.logger(instance->callbacks.componentEnvironment, name, status, category, "%s", text);
    }
#endif
}

#ifdef DEFECT_KEEPS_A_DIARY
static void note(Instance *instance, const char *text) {
    FILE *file = fopen(getenv("DIARY"), "a");
    if (file) {
        fprintf(file, "%s %s\n", instance->name, text);
        fclose(file);
    }
}
#endif

static void start(Instance *instance) {
    uint32_t seed = 1;
#ifdef DEFECT_SEEDED_BY_CLOCK
    seed = (uint32_t)time(NULL);
#endif
#ifdef DEFECT_SEEDED_BY_PROCESS
    seed = (uint32_t)getpid();
#endif
#ifdef DEFECT_SEEDED_BY_LAYOUT /* as what reads memory that nobody has written, or hashes addresses */
    seed = (uint32_t)((uintptr_t)&seed >> 4);
#endif
#ifdef DEFECT_RESET_KEEPS_GENERATOR
    if (instance->now.generator) seed = instance->now.generator;
#endif
    memset(&instance->now, 0, sizeof instance->now);
    memset(instance->array, 0, HISTORY * sizeof(double));
    instance->now.generator = seed;
    instance->now.real[GAIN] = 2.0;
    FILTER = 0.0;
#ifdef DEFECT_READS_WORKING_DIRECTORY
    FILE *file = fopen("resources/gain.txt", "r");
    if (file) {
        if (fscanf(file, "%lf", &instance->now.real[GAIN]) != 1) instance->now.real[GAIN] = 0.0;
        fclose(file);
    }
#endif
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)visible;
#if defined DEFECT_UNDECODED_LOCATION || defined DEFECT_NEEDS_AUTHORITY
    char path[4096];
    snprintf(path, sizeof path, "%s/gain.txt", resources + 7);
#endif
#ifdef DEFECT_UNDECODED_LOCATION
    if (access(path, R_OK) != 0) return NULL;
#endif
#ifdef DEFECT_NEEDS_AUTHORITY
    if (!strchr(path, '%') && access(path, R_OK) != 0) return NULL;
#endif
    (void)resources;
    if (type != fmi2CoSimulation || strcmp(guid, GUID) != 0) return NULL;
#ifdef DEFECT_NEEDS_WORKING_DIRECTORY
    if (access("resources/gain.txt", R_OK) != 0) return NULL;
#endif
    Instance *instance = calloc(1, sizeof(Instance));
    instance->name = strdup(name);
    instance->callbacks = *callbacks;
    instance->logging = logging;
    instance->array = calloc(HISTORY, sizeof(double));
    start(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component component) {
    Instance *instance = component;
    if (!instance) return;
#ifdef DEFECT_KEEPS_A_DIARY
    note(instance, "freed");
#endif
    free(instance->name);
    free(instance->array);
    free(instance);
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    for (size_t i = 0; i < n; i++) {
        if (strcmp(categories[i], "logStatusError") != 0) return fmi2Error;
    }
    ((Instance *)component)->logging = on;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
    Instance *instance = component;
    instance->now.real[SCALED] = instance->now.real[GAIN] * instance->now.real[LEVEL];
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component) {
    (void)component;
#ifdef DEFECT_KEEPS_A_DIARY
    note(component, "terminated");
#endif
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component component) {
    start(component);
    return fmi2OK;
}

static fmi2Status known(Instance *instance, const fmi2ValueReference vr[], size_t n, unsigned limit) {
#ifndef DEFECT_BAD_REFERENCE_CRASHES
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= limit) {
            say(instance, fmi2Error, "no such value reference");
            return fmi2Error;
        }
    }
#else
    (void)instance; (void)vr; (void)n; (void)limit;
#endif
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Instance *instance = component;
    if (known(instance, vr, n, REALS) != fmi2OK) return fmi2Error;
    for (size_t i = 0; i < n; i++) {
        value[i] = instance->now.real[vr[i]];
#ifdef DEFECT_DIRECT_FEEDTHROUGH
        if (vr[i] == FILTERED) value[i] += instance->now.real[RATE];
#endif
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Instance *instance = component;
    if (known(instance, vr, n, REALS) != fmi2OK) return fmi2Error;
#ifdef DEFECT_REFUSES_MOVING_INPUTS
    if (vr[0] == LEVEL && value[0] != 0.0) return fmi2Error;
#endif
    for (size_t i = 0; i < n; i++) instance->now.real[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    Instance *instance = component;
    if (known(instance, vr, n, 1) != fmi2OK) return fmi2Error;
    for (size_t i = 0; i < n; i++) value[i] = instance->now.count;
    return fmi2OK;
}

fmi2Status refused(fmi2Component component) {
    say(component, fmi2Error, "this function is not implemented");
    return fmi2Error;
}

static fmi2Status accepted(Instance *instance, double step) {
#ifdef DEFECT_ACCEPTS_ANY_STEP
    if (step > 0.0) return fmi2OK;
#endif
    if (instance->now.failed || !(fabs(step - STEP) <= 1e-6 * STEP)) {
        instance->now.failed = 1;
        say(instance, fmi2Error, "the step is 0.01 s, no other is accepted");
        return fmi2Error;
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    Instance *instance = component;
    (void)no_return;
    if (accepted(instance, step) != fmi2OK) return fmi2Error;
    Moving *now = &instance->now;
    long k = lround(time / STEP);
#ifdef DEFECT_TRUNCATES_TIME
    k = (long)(time / STEP);
#endif
#ifdef DEFECT_CRASHES
    if (now->count == 5) *(volatile int *)0 = 1;
#endif
#ifdef DEFECT_EATS_MEMORY
    while (now->count == 5) memset(malloc(1 << 28), 1, 1 << 12);
#endif
#ifdef DEFECT_HANGS
    while (now->count == 5) usleep(1000);
#endif
#ifdef DEFECT_WORKS_LONG
    /* half a millisecond of the processor */
    struct timespec at, end;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    end.tv_nsec += 500000;
    do {
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
    } while ((at.tv_sec - end.tv_sec) * 1000000000L + at.tv_nsec < end.tv_nsec);
#endif
#ifdef DEFECT_EXITS
    if (now->count == 5) exit(3);
#endif
#ifdef DEFECT_EXITS_QUIETLY
    if (now->count == 5) exit(0);
#endif
#ifdef DEFECT_RETURNS_FATAL
    if (now->count == 5) {
        say(instance, fmi2Fatal, "beyond repair");
        return fmi2Fatal;
    }
#endif
#ifdef DEFECT_FLOODS_THE_LOG
    if (now->count == 5) {
        char text[1025] = {0};
        memset(text, 'x', 1024);
        for (int i = 0; i < 2048; i++) say(instance, fmi2Warning, text);
        for (int i = 0; i < 2048; i++) puts(text);
        fflush(stdout);
    }
#endif
#ifdef DEFECT_WAITS_FOR_THE_OTHER
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.%d", getenv("MEETING"), instance->name, now->count);
    fclose(fopen(path, "w"));
    for (const char *name = "ab"; *name; name++) {
        snprintf(path, sizeof path, "%s/%c.%d", getenv("MEETING"), *name, now->count);
        while (access(path, F_OK) != 0) usleep(100);
    }
#endif
#ifdef DEFECT_LEAKS
    leaked = malloc(4096);
    memset((void *)leaked, 1, 4096);
#endif
    disturb_process(&now->count);
#ifdef DEFECT_SPOILS_ITS_FOLDERS
    if (now->count == 5) system("for f in ../results/*.npz; do echo spoilt > $f; done");
#endif
#ifdef DEFECT_LEAVES_A_FILE
    FILE *file = fopen("trace.log", "a");
    if (file) fclose(file);
#endif
    now->generator = 1664525u * now->generator + 1013904223u;
    double noise = now->generator / 4294967296.0 - 0.5;
    double before = FILTER;
#ifdef DEFECT_INTEGRATES
    FILTER += step * now->real[RATE];
    before = FILTER; /* true at the end of the step */
#else
    FILTER = 0.9 * FILTER + 0.1 * now->real[RATE];
#endif
#ifdef DEFECT_FEEDTHROUGH_WITHIN_STEP
    before = FILTER;
#endif
    now->real[FILTERED] = before;
    double *past = now->history;
#ifdef DEFECT_HIDDEN_ARRAY
    past = instance->array;
#endif
    past[1 + k % (HISTORY - 1)] = noise;
    double sum = 0.0;
    for (int i = 1; i < HISTORY; i++) sum += past[i] * (i + 1);
    now->real[SCALED] = now->real[GAIN] * now->real[LEVEL] + sum;
    now->count++;
#ifdef DEFECT_NOT_A_NUMBER
    if (now->count > 7) now->real[SCALED] = NAN;
#endif
    return fmi2OK;
}

static void copy(Moving *to, const Moving *from) {
#ifdef DEFECT_HIDDEN_GENERATOR
    uint32_t own = to->generator;
#endif
    *to = *from;
#ifdef DEFECT_HIDDEN_GENERATOR
    to->generator = own;
#endif
}

size_t state_size = sizeof(Moving);

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(Moving));
    memcpy(*state, &((Instance *)component)->now, sizeof(Moving));
#ifdef DEFECT_SHARED_BETWEEN_INSTANCES
    ((Moving *)*state)->history[0] = filter;
#endif
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
    copy(&((Instance *)component)->now, state);
#ifdef DEFECT_SHARED_BETWEEN_INSTANCES
    filter = ((Moving *)state)->history[0];
#endif
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    (void)component;
    memcpy(bytes, state, size);
#ifdef DEFECT_FORGETS_WHEN_SERIALISED
    ((Moving *)(void *)bytes)->generator = 1;
#endif
    return fmi2OK;
}

#ifdef DEFECT_CRASHES_AT_UNLOAD
__attribute__((destructor)) static void unload(void) { abort(); }
#endif
