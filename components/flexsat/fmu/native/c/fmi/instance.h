/* An instance of the FMU, and what the files of the FMI layer call of each other.

What stands in this folder is the same in all versions of FMI. The folder of a version has the functions that hosts
call, the order of these calls, and the way to the host's log. */
#ifndef FLEXSAT_INSTANCE_H
#define FLEXSAT_INSTANCE_H

#include "component.h"
#include "number_text.h"
#include "port_table.h"

#define CATEGORY "logStatusError" /* the only log category */
#define REASON_SIZE 1000          /* bytes of a message */

/* What a call returns; FMI 2.0 and 3.0 give their constants the same numbers. */
typedef enum { CALL_OK, CALL_WARNING, CALL_DISCARD, CALL_ERROR } Status;

/* States of an instance; no step is ever in progress, discarded or cancelled. */
typedef enum { INSTANTIATED = 1, INITIALIZING, STEPPING, TERMINATED, FAILED } Phase;

/* What a host calls, by the rows of the table that each version of FMI has. */
typedef enum {
    SETUP_EXPERIMENT,
    ENTER_INITIALIZATION,
    EXIT_INITIALIZATION,
    DO_STEP,
    TERMINATE,
    GET,
    SET,
    DIFFERENTIATE,
    CALLS
} Call;

/* Where log messages go. */
typedef struct Host {
    void (*logger)(void); /* NULL, or a function of the type that the version of FMI has */
    void *environment;    /* what it gets */
    int logging;          /* whether the host wants messages, where a version of FMI leaves it the choice */
} Host;

/* A saved state: the bytes that are serialised, but for the digest at their end. A host gets its address. */
typedef struct State {
    struct State *next;
    size_t size;
    unsigned char *bytes;
} State;

typedef struct Instance {
    Component component;
    Memory memory; /* of the instance itself: its name and values */
    Host host;
    char *name;    /* as the host wrote it */
    double *seed, *change; /* by places of reals, of derivatives; NULL if there are none */
    Phase phase;
    int set_up;    /* whether start and stop time are known */
    int ends;      /* whether the experiment has a stop time */
    double stop;   /* s */
    double present;    /* s, the communication point that the model has reached */
    double fixed_step; /* s, the only step accepted since the start; 0: none */
    double length;     /* s, of all steps, where the first one sets it; 0: no step was made */
    int started;       /* the model has started with the present parameters and inputs */
    int stale;         /* outputs on demand are older than the state */
    int inputs_set;    /* since outputs that follow inputs were computed */
    State *states;
    unsigned char *values_before; /* those before a state is restored; they come back if it is refused */
    char failure[REASON_SIZE]; /* why the phase is FAILED */
} Instance;

/* Of each version of FMI, in its folder */
/* Send a line of UTF-8 to the host's log, if it has one. */
void send_to_host(const Host *host, const char *name, Status status, const char *text);
/* Return CALL_OK, or CALL_ERROR after a refusal. */
Status check_order(Instance *instance, Call call, const char *name);

/* messages.c */
void log_to_host(const Host *host, const char *name, Status status, const char *format, ...);
/* Log "call: why", stop the instance, and return CALL_ERROR. */
Status refuse_call(Instance *instance, const char *call, const char *format, ...);
/* The same for what the model refused, whose state is unknown then. */
Status refuse_for_model(Instance *instance, const char *call);

/* utf8.c */
int is_utf8(const char *text);
/* Replace bytes that are not UTF-8, and control characters such as line feeds. */
void make_line(char *text);

/* life_cycle.c */
/* Return an instance, or NULL with the reason in the host's log. Nothing has been taken of `memory`; `known_as`: what
this version of FMI calls the GUID. */
Instance *instantiate(const char *call, const char *name, const char *guid, const char *known_as, Memory memory,
                      const Host *host);
void begin_anew(Instance *instance);
void free_instance(Instance *instance);
/* Choose log categories: CALL_WARNING if one is unknown. */
Status choose_categories(Instance *instance, size_t n, const char *const categories[]);
/* Set start time, stop time and tolerance. */
Status set_experiment(Instance *instance, const char *call, int tolerant, double tolerance, double start, int ends,
                      double stop);
Status enter_initialization(Instance *instance);
Status exit_initialization(Instance *instance);
Status terminate(Instance *instance);
Status make_step(Instance *instance, double time, double step);

/* communication_points.c: returns 0, and writes why a step is refused; else 1, and the length to step by. */
int admit_step(Instance *instance, double time, double step, double *length, char reason[REASON_SIZE]);

/* port_values.c */
void set_start_values(Component *component);
const Port *port_at(Kind kind, int place);
const char *variable_name(const Port *port, int place, char name[REASON_SIZE]);
/* Whether a value of a port may be set; `why` is written if not. */
int acceptable(const Port *port, double value, char why[REASON_SIZE]);
/* The first of so many real outputs that is not finite, or -1. */
int output_not_finite(const Component *component, int count);
void poison_outputs(Component *component);

/* value_access.c: what is done before values are read and written, and after */
/* Compute what has to be computed before variables with these flags are read. */
Status begin_to_read(Instance *instance, const char *call, int flags);
/* Refuse what may not be set, and values that are not accepted. */
Status check_number(Instance *instance, const char *call, const Port *port, int place, double value);
/* The same of reals that follow one on the other in a port, from `place` on. */
Status check_numbers(Instance *instance, const char *call, const Port *port, int place, size_t n,
                     const double values[]);
Status check_boolean(Instance *instance, const char *call, const Port *port, int place, int value);
/* `number`: of the value in its list, from 1 */
Status check_text(Instance *instance, const char *call, const Port *port, int place, const char *value,
                  size_t number);
/* Note that values were written, with these flags among them. */
Status finish_writing(Instance *instance, const char *call, int flags);

/* derivatives.c */
Status begin_to_differentiate(Instance *instance, const char *call);
/* Add to the seed of an input; refuse what is not finite. */
Status add_seed(Instance *instance, const char *call, int place, double value, size_t number);
/* Find `change` in the direction of `seed`. */
Status differentiate(Instance *instance, const char *call);
/* Refuse the derivative of an output if it is not finite. */
Status check_derivative(Instance *instance, const char *call, int place);

/* model_calls.c */
/* Start the model: returns 0 with component.message, or 1. */
int start_component(Instance *instance);
/* The others return CALL_OK, or CALL_ERROR after a refusal. Start unless started with the present parameters: */
Status start_model(Instance *instance, const char *call);
/* Compute outputs that are on demand, or follow inputs, if one with these flags is read: */
Status compute_outputs(Instance *instance, const char *call, int flags);
Status check_outputs(Instance *instance, const char *call);

/* saved_state.c */
size_t values_size(void); /* bytes of the values of all ports */
size_t saved_size(const Instance *instance);
void save(const Instance *instance, unsigned char *bytes);
/* Restore what was saved by an instance of this FMU: 1, or 0 with the reason. `model`: the model refused it. */
int restore(Instance *instance, const unsigned char *bytes, size_t size, char reason[REASON_SIZE], int *model);
/* Whether bytes without their digest are a saved state of this FMU. */
int is_saved_state(const unsigned char *bytes, size_t size, char reason[REASON_SIZE]);
#define DIGEST_SIZE 8
void digest_of(const unsigned char *bytes, size_t size, unsigned char digest[DIGEST_SIZE]);

/* kept_states.c: states of which hosts have the address; `call` is named in refusals */
Status keep_state(Instance *instance, const char *call, void **state);
Status restore_kept(Instance *instance, const char *call, const void *state);
Status free_state(Instance *instance, const char *call, void **state);
Status serialised_size(Instance *instance, const char *call, const void *state, size_t *size);
Status serialise(Instance *instance, const char *call, const void *state, unsigned char bytes[], size_t size);
Status deserialise(Instance *instance, const char *call, const unsigned char bytes[], size_t size, void **state);
void free_states(Instance *instance);

#endif
