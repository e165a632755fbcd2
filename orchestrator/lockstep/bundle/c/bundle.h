/* A bundle: components, the bus between them, the ports of the bundle, and where in its life it is. */
#ifndef BUNDLE_BUNDLE_H
#define BUNDLE_BUNDLE_H

#include <stdint.h>

#include "fmi2.h"
#include "fmi3.h"
#include "tick.h"

enum { REAL, INTEGER, BOOLEAN, STRING, ALL_TYPES, BUS_TYPES = STRING, ENUMERATION = ALL_TYPES };
enum { INPUT, OUTPUT, PARAMETER, TUNABLE };           /* kinds of ports */
enum { CONTINUOUS = 1, EARLY = 2, SAVES_STATE = 4, VERSION_3 = 8 };  /* flags of a component */

typedef struct bundle bundle_t;

typedef struct {
    uint32_t count;
    uint32_t *items;
} counts_t;

/* Values to set: each target gets gain * source + bias; without gains, the source. */
typedef struct {
    uint32_t type, count, producer;
    uint32_t *targets;
    int64_t *sources;
    double *gains, *biases;
    void *buffer;
} set_t;

/* Values to fetch to successive places. */
typedef struct {
    uint32_t type, count, start;
    uint32_t *references;
    unsigned char *unused; /* by connections: such a value need not be finite */
    int checked;           /* whether one is used */
} get_t;

typedef struct {
    uint32_t component, set_count, get_count;
    set_t *sets;
    get_t *gets;
} step_t;

typedef struct {
    counts_t early, late;
    uint32_t row; /* counts from 1; 0: none */
} tick_t;

/* What an operation of the tick belongs to. */
typedef struct {
    uint32_t component;
    const set_t *set;
    const get_t *get;
} origin_t;

typedef struct {
    counts_t references;
    void *values;
} start_t;

typedef struct {
    counts_t references;
    const char **texts;
} names_t;

typedef struct {
    void *library;
    fmi2InstantiateFunction instantiate;
    fmi2FreeInstanceFunction free_instance;
    fmi2SetDebugLoggingFunction set_debug_logging;
    fmi2SetupExperimentFunction setup_experiment;
    fmi2PlainFunction enter_initialization, exit_initialization, terminate, reset;
    fmi2DoStepFunction do_step;
    fmi2GetFunction get[ALL_TYPES];
    fmi2SetFunction set[ALL_TYPES];
    fmi2GetStateFunction get_state, free_state;
    fmi2SetStateFunction set_state;
    fmi2StateSizeFunction state_size;
    fmi2SerializeFunction serialize;
    fmi2DeSerializeFunction deserialize;
    fmi2GetRealStatusFunction real_status;
    fmi2GetBooleanStatusFunction boolean_status;
    /* of FMI 3.0, where they differ */
    fmi3InstantiateFunction instantiate3;
    fmi3SetDebugLoggingFunction set_debug_logging3;
    fmi3EnterInitializationFunction enter_initialization3;
    fmi3DoStepFunction do_step3;
    fmi3GetFunction get3[ALL_TYPES];
    fmi3SetFunction set3[ALL_TYPES];
} functions_t;

/* The arrays of one type of a component of FMI 3.0, those that can be set first. Each has a value reference and begins
at a position; the end of the last one is the size of the memory. */
typedef struct {
    uint32_t count, settable; /* arrays, and elements that can be set */
    uint32_t *handles, *begins, *array_of;
    unsigned char *touched;
    void *starts, *memory; /* what can be set: Booleans of 4 bytes, and as the FMU has it */
    void *fetched;         /* what was got last */
} arrays_t;

/* Where an element is; its type is ALL_TYPES if a bundle cannot carry it. */
typedef struct {
    uint32_t type, position;
} element_t;

typedef struct {
    int tolerant, ends;
    double tolerance, start, stop;
} experiment_t;

typedef struct {
    bundle_t *bundle;
    const char *name, *folder, *identifier, *guid;
    uint32_t flags, period, offset;
    double length, tolerance; /* of a step [s]; 0: no tolerance */
    start_t starts[ALL_TYPES];
    names_t names[BUS_TYPES]; /* of what connections transfer */
    uint32_t initial_set_count, initial_get_count, initial_bus_count;
    set_t *initial_sets;
    get_t *initial_gets, *initial_bus;
    int fetched; /* its initial outputs are among the initial values */
    arrays_t arrays[ALL_TYPES];
    element_t *elements; /* by reference */
    uint32_t element_count;
    experiment_t experiment;
    fmi3Boolean flags3[3]; /* of a step: events, end, early return */
    double reached;
    functions_t call;
    fmi2CallbackFunctions callbacks;
    fmi2Component instance;
    fmi2Status worst;
} component_t;

typedef struct {
    uint32_t component, reference;
    double gain, bias;
} target_t;

typedef struct {
    uint32_t kind, type, place, target_count;
    target_t *targets;
    int given; /* the host has set it since instantiation or reset */
    double real_start;
    int32_t whole_start;
    const char *text_start;
    double real;
    int32_t whole;
    char *text; /* owned */
} port_t;

/* What a host sees as one variable: successive ports of one type. FMI 2.0 has no arrays: each is one port. */
typedef struct {
    uint32_t first, count, shown; /* the type, or ENUMERATION */
} variable_t;

/* The functions of the host, whatever its version of FMI. */
typedef struct {
    void (*logger)(void);
    void *environment;
    fmi2CallbackAllocateMemory allocate;
    fmi2CallbackFreeMemory release;
} host_t;

/* Memory that grows with what a host asks for. */
typedef struct {
    void *memory;
    size_t size;
} room_t;

typedef enum { INSTANTIATED, INITIALISING, STEPPING, TERMINATED, FAILED, FATAL } life_t;

typedef struct saved saved_t;

struct bundle {
    char *name, *resources, *resources_uri;
    host_t host;
    int logging;
    life_t life;
    const char *guid;
    unsigned char *program;
    void *blocks; /* all memory of the program, in a list */
    int64_t second; /* units of time in 1 s */
    uint32_t step_ticks, component_count, port_count, variable_count, step_count, row_count, cycle, most_values;
    uint32_t bus_size[BUS_TYPES], slot_count[BUS_TYPES], row_size[BUS_TYPES];
    component_t *components;
    port_t *ports;
    variable_t *variables;
    counts_t order;
    step_t *steps;
    counts_t (*rows)[BUS_TYPES];
    tick_t *ticks;
    void *bus[BUS_TYPES], *slots[BUS_TYPES], *row[BUS_TYPES];
    /* scratch of one call from the host */
    uint32_t *references;
    void *values;
    room_t expanded, given; /* the ports behind a host's variables, and their values */
    /* experiment */
    double start, stop, tolerance;
    int stop_defined, tolerance_defined;
    tick_state state;         /* at a communication point it is at the mark of a tick */
    tick_operation *mark;     /* between what comes before and after the row of a tick */
    uint64_t *mark_positions; /* in the order of operations, by tick of the cycle */
    origin_t *origins;        /* by operation */
    int propagated;       /* initial outputs are those of the inputs as they are */
    int ended;            /* a component asked for the end */
    saved_t *states;
};

extern const size_t sizes[ALL_TYPES];

/* Return the time at which a tick begins [s]: the nearest double, never a sum of steps. */
double time_of(const bundle_t *bundle, int64_t tick);
double time_now(const bundle_t *bundle); /* of the present tick */

#endif
