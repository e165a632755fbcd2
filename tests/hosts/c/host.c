/*
 * A minimal FMI 2.0 host without Python: one FMU through its whole life, or several in a closed loop in one process; for
 * Linux, and for Windows, where all that is said of Python here does not apply.
 *
 *     gcc -std=c11 -Wall -Wextra -Werror -I FOLDER_OF_FMI2_HEADERS host.c -o host -ldl
 *     ./host SETUP [LIBPYTHON]
 *
 * What an FMU made by pythonfmu needs of a host that is no Python, as tested with this one on Linux:
 *
 * 1. libpython's symbols must be there for all before fmi2Instantiate. The FMU loads libpython3.11.so.1.0 by itself
 *    where the system finds it (LD_LIBRARY_PATH). Or start the host with LD_PRELOAD=LIBPYTHON, or let it
 *    dlopen(LIBPYTHON, RTLD_NOW | RTLD_GLOBAL) first, as here when it is named. LIBPYTHON is LIBDIR/INSTSONAME of
 *    Python's sysconfig; Debian's package is libpython3.11.
 * 2. PYTHONHOME=sys.base_prefix of that Python. Without it the interpreter looks for a `python3` on the PATH, and if
 *    that is another one, it takes that one's library: "No module named '_struct'", and no instance.
 * 3. PYTHONPATH=the folder that holds numpy, unless numpy is installed in that Python itself. Without numpy: "No module
 *    named 'numpy'", and no instance. Nothing else: pythonfmu and the model travel in the FMU's resources.
 * 4. OPENBLAS_NUM_THREADS=1, for the same bits as any other host. With more threads the last digits differ.
 * 5. fmuResourceLocation is the file: URI of the folder `resources`; the working directory does not matter.
 * 6. At the end: fmi2Terminate and fmi2FreeInstance of every instance, then dlclose of every FMU. libpython stays.
 *
 * SETUP is a text of lines, which the test writes:
 *
 *     run TICKS NANOSECONDS                   how many ticks, and how long one is
 *     fmu NAME LIBRARY RESOURCES GUID PERIOD  a component that steps every PERIOD ticks; in order of stepping
 *     real|integer|boolean REFERENCE VALUE    a start value of the component above
 *     drive REFERENCE VALUE                   a real input of the component above that moves about VALUE
 *     wire|flag REFERENCE COMPONENT REFERENCE an input (real, boolean) of the component above and where it comes from
 *     watch REFERENCE                         a real output of the component above to print
 *     stateless                               do not ask for states, for an FMU that has none to give
 *
 * Components are initialised last one first, so that the initial outputs of the plant, which is last, reach the others.
 * The host prints one line of 17 digits each tick. From the middle of the run it goes on from a saved state, from a
 * serialised one and once more from fmi2Reset, and fails if any output then differs in any bit.
 */
#ifndef _WIN32
#define _GNU_SOURCE
#endif
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dynamic_library.h"
#include "fmi2Functions.h"

enum { MOST_COMPONENTS = 4, MOST_ENTRIES = 4096, WORD = 4096 };

typedef struct {
    fmi2ValueReference reference;
    double value;                     /* start value, or what a driven input moves about */
    int source;                       /* component that a wire comes from */
    fmi2ValueReference source_reference;
} Entry;

typedef struct {
    Entry entry[MOST_ENTRIES];
    int count;
} List;

typedef struct {
    char name[WORD], path[WORD], resources[WORD], guid[WORD];
    long long period;
    List reals, integers, booleans, drives, wires, flags, watches;
    void *library;
    fmi2Component instance;
    fmi2FMUstate state;
    fmi2Byte *bytes;
    size_t size;
    fmi2InstantiateTYPE *instantiate;
    fmi2FreeInstanceTYPE *free_instance;
    fmi2SetupExperimentTYPE *setup_experiment;
    fmi2EnterInitializationModeTYPE *enter_initialization;
    fmi2ExitInitializationModeTYPE *exit_initialization;
    fmi2TerminateTYPE *terminate;
    fmi2ResetTYPE *reset;
    fmi2DoStepTYPE *do_step;
    fmi2GetRealTYPE *get_real;
    fmi2SetRealTYPE *set_real;
    fmi2SetIntegerTYPE *set_integer;
    fmi2GetBooleanTYPE *get_boolean;
    fmi2SetBooleanTYPE *set_boolean;
    fmi2GetFMUstateTYPE *get_state;
    fmi2SetFMUstateTYPE *set_state;
    fmi2FreeFMUstateTYPE *free_state;
    fmi2SerializedFMUstateSizeTYPE *serialized_size;
    fmi2SerializeFMUstateTYPE *serialize;
    fmi2DeSerializeFMUstateTYPE *deserialize;
} Component;

static Component *components;
static int count, stateless;
static long long ticks, tick_length; /* [1], [ns] */

static void fail(const char *what, const char *about) {
    fprintf(stderr, "host: %s: %s\n", what, about);
    exit(1);
}

static void check(fmi2Status status, const char *call, const Component *of) {
    if (status != fmi2OK) {
        fprintf(stderr, "host: %s: %s returned %d\n", of->name, call, (int)status);
        exit(1);
    }
}

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {
    va_list arguments;
    (void)environment;
    if (status == fmi2OK) return; /* such as the container's list of all calls */
    fprintf(stderr, "%s: status %d, %s: ", name, (int)status, category);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};

static void add(List *list, FILE *file, const char *format, int from_other) {
    Entry *entry = &list->entry[list->count++];
    int found = from_other ? fscanf(file, format, &entry->reference, &entry->source, &entry->source_reference)
                           : fscanf(file, format, &entry->reference, &entry->value);
    if (list->count == MOST_ENTRIES || found < 1) fail("bad setup", format);
}

static void read_setup(const char *path) {
    FILE *file = fopen(path, "r");
    static char word[WORD];
    Component *c = NULL;
    if (!file) fail("cannot open", path);
    while (fscanf(file, "%4095s", word) == 1) {
        if (!strcmp(word, "run")) {
            if (fscanf(file, "%lld %lld", &ticks, &tick_length) != 2) fail("bad setup", word);
        } else if (!strcmp(word, "stateless")) {
            stateless = 1;
        } else if (!strcmp(word, "fmu")) {
            if (count == MOST_COMPONENTS) fail("too many components", path);
            c = &components[count++];
            if (fscanf(file, "%4095s %4095s %4095s %4095s %lld", c->name, c->path, c->resources, c->guid,
                       &c->period) != 5)
                fail("bad setup", word);
        } else if (!c) fail("no component yet", word);
        else if (!strcmp(word, "real")) add(&c->reals, file, "%u %lf", 0);
        else if (!strcmp(word, "integer")) add(&c->integers, file, "%u %lf", 0);
        else if (!strcmp(word, "boolean")) add(&c->booleans, file, "%u %lf", 0);
        else if (!strcmp(word, "drive")) add(&c->drives, file, "%u %lf", 0);
        else if (!strcmp(word, "watch")) add(&c->watches, file, "%u", 0);
        else if (!strcmp(word, "wire")) add(&c->wires, file, "%u %d %u", 1);
        else if (!strcmp(word, "flag")) add(&c->flags, file, "%u %d %u", 1);
        else fail("unknown word in setup", word);
    }
    fclose(file);
}

static void *symbol(const Component *c, const char *name) {
    void *found = find_symbol(c->library, name);
    if (!found) fail(c->name, library_error());
    return found;
}

static void load(Component *c) {
    c->library = open_library(c->path);
    if (!c->library) fail("cannot load the FMU", library_error());
    if (strcmp(((fmi2GetVersionTYPE *)symbol(c, "fmi2GetVersion"))(), fmi2Version)) fail(c->name, "not FMI 2.0");
    c->instantiate = symbol(c, "fmi2Instantiate");
    c->free_instance = symbol(c, "fmi2FreeInstance");
    c->setup_experiment = symbol(c, "fmi2SetupExperiment");
    c->enter_initialization = symbol(c, "fmi2EnterInitializationMode");
    c->exit_initialization = symbol(c, "fmi2ExitInitializationMode");
    c->terminate = symbol(c, "fmi2Terminate");
    c->reset = symbol(c, "fmi2Reset");
    c->do_step = symbol(c, "fmi2DoStep");
    c->get_real = symbol(c, "fmi2GetReal");
    c->set_real = symbol(c, "fmi2SetReal");
    c->set_integer = symbol(c, "fmi2SetInteger");
    c->get_boolean = symbol(c, "fmi2GetBoolean");
    c->set_boolean = symbol(c, "fmi2SetBoolean");
    c->get_state = symbol(c, "fmi2GetFMUstate");
    c->set_state = symbol(c, "fmi2SetFMUstate");
    c->free_state = symbol(c, "fmi2FreeFMUstate");
    c->serialized_size = symbol(c, "fmi2SerializedFMUstateSize");
    c->serialize = symbol(c, "fmi2SerializeFMUstate");
    c->deserialize = symbol(c, "fmi2DeSerializeFMUstate");
}

/* Transfer the values of wires; consecutive ones from one component in one call. */
static void transfer(Component *c) {
    static fmi2ValueReference from[MOST_ENTRIES], to[MOST_ENTRIES];
    static fmi2Real values[MOST_ENTRIES];
    for (int i = 0, n; i < c->wires.count; i += n) {
        const Entry *wire = &c->wires.entry[i];
        Component *source = &components[wire->source];
        for (n = 0; i + n < c->wires.count && wire[n].source == wire->source; n++) {
            from[n] = wire[n].source_reference;
            to[n] = wire[n].reference;
        }
        check(source->get_real(source->instance, from, (size_t)n, values), "fmi2GetReal", source);
        check(c->set_real(c->instance, to, (size_t)n, values), "fmi2SetReal", c);
    }
    for (int i = 0; i < c->flags.count; i++) {
        const Entry *wire = &c->flags.entry[i];
        Component *source = &components[wire->source];
        fmi2Boolean value;
        check(source->get_boolean(source->instance, &wire->source_reference, 1, &value), "fmi2GetBoolean", source);
        check(c->set_boolean(c->instance, &wire->reference, 1, &value), "fmi2SetBoolean", c);
    }
}

/* Read what is watched; return where the next value goes. */
static double *watch(Component *c, double *trace) {
    static fmi2ValueReference references[MOST_ENTRIES];
    for (int i = 0; i < c->watches.count; i++) references[i] = c->watches.entry[i].reference;
    check(c->get_real(c->instance, references, (size_t)c->watches.count, trace), "fmi2GetReal", c);
    return trace + c->watches.count;
}

static void initialise(void) {
    for (int k = count - 1; k >= 0; k--) {
        Component *c = &components[k];
        for (int i = 0; i < c->reals.count; i++) {
            const Entry *start = &c->reals.entry[i];
            check(c->set_real(c->instance, &start->reference, 1, &start->value), "fmi2SetReal", c);
        }
        for (int i = 0; i < c->integers.count; i++) {
            fmi2Integer value = (fmi2Integer)c->integers.entry[i].value;
            check(c->set_integer(c->instance, &c->integers.entry[i].reference, 1, &value), "fmi2SetInteger", c);
        }
        for (int i = 0; i < c->booleans.count; i++) {
            fmi2Boolean value = c->booleans.entry[i].value != 0.0;
            check(c->set_boolean(c->instance, &c->booleans.entry[i].reference, 1, &value), "fmi2SetBoolean", c);
        }
        check(c->setup_experiment(c->instance, fmi2False, 0.0, 0.0, fmi2False, 0.0), "fmi2SetupExperiment", c);
        check(c->enter_initialization(c->instance), "fmi2EnterInitializationMode", c);
    }
    for (int k = count - 1; k >= 0; k--) {
        transfer(&components[k]);
        check(components[k].exit_initialization(components[k].instance), "fmi2ExitInitializationMode", &components[k]);
    }
}

/* Step from one tick to another; keep what is watched in `trace`, one row a tick. */
static void run(long long first, long long last, double *trace) {
    for (long long tick = first; tick < last; tick++) {
        for (int k = 0; k < count; k++) {
            Component *c = &components[k];
            if (tick % c->period) continue;
            transfer(c);
            for (int i = 0; i < c->drives.count; i++) {
                double value = c->drives.entry[i].value + (double)((7 * tick + 13 * i) % 23 - 11) / 1048576.0;
                check(c->set_real(c->instance, &c->drives.entry[i].reference, 1, &value), "fmi2SetReal", c);
            }
            check(c->do_step(c->instance, (double)(tick * tick_length) / 1e9, (double)(c->period * tick_length) / 1e9,
                             fmi2True), "fmi2DoStep", c);
        }
        for (int k = 0; k < count; k++) trace = watch(&components[k], trace);
    }
}

/* The whole run, its second half twice more from a saved and from a serialised state. */
static void fly(double *trace, double *again, long long width) {
    long long half = ticks / 2;
    size_t rest = (size_t)((ticks - half) * width) * sizeof *trace;
    run(0, half, trace);
    if (stateless) {
        run(half, ticks, trace + half * width);
        return;
    }
    for (int k = 0; k < count; k++) {
        Component *c = &components[k];
        c->state = NULL;
        check(c->get_state(c->instance, &c->state), "fmi2GetFMUstate", c);
        check(c->serialized_size(c->instance, c->state, &c->size), "fmi2SerializedFMUstateSize", c);
        c->bytes = malloc(c->size);
        check(c->serialize(c->instance, c->state, c->bytes, c->size), "fmi2SerializeFMUstate", c);
    }
    run(half, ticks, trace + half * width);
    for (int serialised = 0; serialised < 2; serialised++) {
        for (int k = 0; k < count; k++) {
            Component *c = &components[k];
            if (serialised)
                check(c->deserialize(c->instance, c->bytes, c->size, &c->state), "fmi2DeSerializeFMUstate", c);
            check(c->set_state(c->instance, c->state), "fmi2SetFMUstate", c);
            check(c->free_state(c->instance, &c->state), "fmi2FreeFMUstate", c);
            c->state = NULL;
            if (serialised) free(c->bytes);
        }
        run(half, ticks, again);
        if (memcmp(again, trace + half * width, rest)) fail("not the same from", serialised ? "bytes" : "a state");
    }
}

int main(int argument_count, char **arguments) {
    long long width = 0;
    if (argument_count < 2) fail("usage", "host SETUP [LIBPYTHON]");
    components = calloc(MOST_COMPONENTS, sizeof *components);
    read_setup(arguments[1]);
    if (argument_count > 2 && !open_for_all(arguments[2])) fail("cannot load libpython", library_error());
    for (int k = 0; k < count; k++) {
        Component *c = &components[k];
        load(c);
        c->instance = c->instantiate(c->name, fmi2CoSimulation, c->guid, c->resources, &callbacks, fmi2False, fmi2True);
        if (!c->instance) fail("cannot instantiate", c->name);
        width += c->watches.count;
    }
    size_t size = (size_t)(ticks * width) * sizeof(double);
    double *first = malloc(size), *trace = malloc(size), *again = malloc(size);
    if (!first || !trace || !again) fail("no memory", arguments[1]);
    initialise();
    fly(first, again, width);
    for (int k = 0; k < count; k++) check(components[k].reset(components[k].instance), "fmi2Reset", &components[k]);
    initialise();
    fly(trace, again, width);
    if (memcmp(first, trace, size)) fail("not the same after", "fmi2Reset");
    for (int k = 0; k < count; k++) {
        check(components[k].terminate(components[k].instance), "fmi2Terminate", &components[k]);
        components[k].free_instance(components[k].instance);
    }
    for (int k = 0; k < count; k++)
        if (close_library(components[k].library)) fail("cannot unload", library_error());
    for (long long i = 0; i < ticks * width; i++) printf("%.17g%c", trace[i], (i + 1) % width ? ' ' : '\n');
    free(trace), free(again), free(first), free(components);
    return 0;
}
