/* Native FMUs in a bare loop, timed: `./native_loop SETUP TICKS`. The setup is that of tests/hosts/c/host.c, without
`watch`. Printed: name, median and 99.9 % and longest step of each component [us], then the processor time of the loop a
tick [us], and what the transfers took of it. */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2Functions.h"

enum { MOST_COMPONENTS = 4, MOST_ENTRIES = 4096, WORD = 4096 };

typedef struct {
    int source, count, boolean; /* values that come from one component, in one call */
    fmi2ValueReference from[MOST_ENTRIES], to[MOST_ENTRIES];
} Transfer;

typedef struct {
    char name[WORD];
    long period, steps;
    int transfers;
    Transfer *transfer;
    float *spent; /* us, of each step */
    fmi2Component instance;
    fmi2DoStepTYPE *do_step;
    fmi2GetRealTYPE *get_real;
    fmi2SetRealTYPE *set_real;
    fmi2GetBooleanTYPE *get_boolean;
    fmi2SetBooleanTYPE *set_boolean;
    fmi2SetIntegerTYPE *set_integer;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
} Part;

static Part parts[MOST_COMPONENTS];
static int count;

static void check(int failed, const char *what)
{
    if (failed) {
        fprintf(stderr, "native_loop: %s failed\n", what);
        exit(1);
    }
}

static void quiet(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String message, ...)
{
    (void)environment, (void)category;
    if (status > fmi2Warning)
        fprintf(stderr, "%s: %s\n", name, message);
}

static const fmi2CallbackFunctions callbacks = {quiet, calloc, free, NULL, NULL};

static double now(clockid_t clock)
{
    struct timespec time;

    clock_gettime(clock, &time);
    return 1e6 * (double)time.tv_sec + 1e-3 * (double)time.tv_nsec;
}

static void *symbol(void *library, const char *name)
{
    void *found = dlsym(library, name);

    check(found == NULL, name);
    return found;
}

static void load(Part *part, const char *path, const char *resources, const char *guid)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);

    check(library == NULL, path);
    part->do_step = symbol(library, "fmi2DoStep");
    part->get_real = symbol(library, "fmi2GetReal");
    part->set_real = symbol(library, "fmi2SetReal");
    part->get_boolean = symbol(library, "fmi2GetBoolean");
    part->set_boolean = symbol(library, "fmi2SetBoolean");
    part->set_integer = symbol(library, "fmi2SetInteger");
    part->enter = symbol(library, "fmi2EnterInitializationMode");
    part->leave = symbol(library, "fmi2ExitInitializationMode");
    part->instance = ((fmi2InstantiateTYPE *)symbol(library, "fmi2Instantiate"))(
        part->name, fmi2CoSimulation, guid, resources, &callbacks, fmi2False, fmi2False);
    check(part->instance == NULL, "fmi2Instantiate");
    check(((fmi2SetupExperimentTYPE *)symbol(library, "fmi2SetupExperiment"))(part->instance, fmi2False, 0.0, 0.0,
                                                                             fmi2False, 0.0), "fmi2SetupExperiment");
    part->transfer = calloc(MOST_COMPONENTS * 4, sizeof *part->transfer);
    check(part->transfer == NULL, "calloc");
}

static void add_wire(Part *part, int boolean, fmi2ValueReference to, int source, fmi2ValueReference from)
{
    Transfer *transfer = part->transfer + part->transfers - 1;

    if (part->transfers == 0 || transfer->source != source || transfer->boolean != boolean) {
        check(part->transfers == MOST_COMPONENTS * 4, "more transfers");
        transfer = part->transfer + part->transfers++;
        transfer->source = source;
        transfer->boolean = boolean;
    }
    check(transfer->count == MOST_ENTRIES, "more wires");
    transfer->from[transfer->count] = from;
    transfer->to[transfer->count++] = to;
}

static void read_setup(const char *path, long *tick_length)
{
    FILE *file = fopen(path, "r");
    static char word[WORD], library[WORD], resources[WORD], guid[WORD];
    Part *part = parts;
    long ticks;

    check(file == NULL, path);
    while (fscanf(file, "%4095s", word) == 1) {
        fmi2ValueReference reference, from;
        double value;
        int source;
        if (!strcmp(word, "run")) {
            check(fscanf(file, "%ld %ld", &ticks, tick_length) != 2, word);
        } else if (!strcmp(word, "fmu")) {
            check(count == MOST_COMPONENTS, "more components");
            part = &parts[count++];
            check(fscanf(file, "%4095s %4095s %4095s %4095s %ld", part->name, library, resources, guid,
                         &part->period) != 5, word);
            load(part, library, resources, guid);
        } else if (!strcmp(word, "wire") || !strcmp(word, "flag")) {
            check(fscanf(file, "%u %d %u", &reference, &source, &from) != 3, word);
            add_wire(part, word[0] == 'f', reference, source, from);
        } else {
            check(fscanf(file, "%u %lf", &reference, &value) != 2, word);
            if (!strcmp(word, "real")) {
                check(part->set_real(part->instance, &reference, 1, &value), "fmi2SetReal");
            } else {
                const int whole = (int)value;
                check((word[0] == 'b' ? part->set_boolean : part->set_integer)(part->instance, &reference, 1, &whole),
                      "a start value");
            }
        }
    }
    fclose(file);
}

static void transfer(Part *part)
{
    static double reals[MOST_ENTRIES];
    static int booleans[MOST_ENTRIES];
    int k;

    for (k = 0; k < part->transfers; k++) {
        const Transfer *one = part->transfer + k;
        const Part *source = &parts[one->source];
        const size_t size = (size_t)one->count;
        if (one->boolean)
            check(source->get_boolean(source->instance, one->from, size, booleans) ||
                  part->set_boolean(part->instance, one->to, size, booleans), "a transfer");
        else
            check(source->get_real(source->instance, one->from, size, reals) ||
                  part->set_real(part->instance, one->to, size, reals), "a transfer");
    }
}

static int compare(const void *one, const void *other)
{
    const float a = *(const float *)one, b = *(const float *)other;

    return (a > b) - (a < b);
}

int main(int arguments_given, char **arguments)
{
    long tick, tick_length = 0, ticks;
    double begun, total, inside = 0.0;
    int k;

    check(arguments_given != 3, "usage: native_loop SETUP TICKS;");
    read_setup(arguments[1], &tick_length);
    ticks = atol(arguments[2]);
    for (k = count - 1; k >= 0; k--)
        check(parts[k].enter(parts[k].instance), "fmi2EnterInitializationMode");
    for (k = count - 1; k >= 0; k--) {
        transfer(&parts[k]);
        check(parts[k].leave(parts[k].instance), "fmi2ExitInitializationMode");
        parts[k].spent = calloc((size_t)(ticks / parts[k].period + 1), sizeof(float));
        check(parts[k].spent == NULL, "calloc");
    }
    begun = now(CLOCK_PROCESS_CPUTIME_ID);
    for (tick = 0; tick < ticks; tick++)
        for (k = 0; k < count; k++) {
            Part *part = &parts[k];
            double from;
            if (tick % part->period)
                continue;
            transfer(part);
            from = now(CLOCK_MONOTONIC);
            check(part->do_step(part->instance, (double)(tick * tick_length) / 1e9,
                                (double)(part->period * tick_length) / 1e9, fmi2True), "fmi2DoStep");
            part->spent[part->steps++] = (float)(now(CLOCK_MONOTONIC) - from);
        }
    total = (now(CLOCK_PROCESS_CPUTIME_ID) - begun) / (double)ticks;
    for (k = 0; k < count; k++) {
        Part *part = &parts[k];
        const long n = part->steps;
        qsort(part->spent, (size_t)n, sizeof(float), compare);
        printf("%s %.3f %.3f %.3f\n", part->name, part->spent[n / 2], part->spent[n - 1 - n / 1000],
               part->spent[n - 1]);
        inside += part->spent[n / 2] / (double)part->period;
    }
    printf("loop %.3f %.3f\n", total, total - inside);
    return 0;
}
