/* An instance of the FMU, and what the files of the FMI layer call of each other. */
#ifndef FLEXSAT_INSTANCE_H
#define FLEXSAT_INSTANCE_H

#include "component.h"
#include "fmi2.h"
#include "number_text.h"
#include "port_table.h"

#define CATEGORY "logStatusError" /* the only log category */
#define REASON_SIZE 1000          /* bytes of a message */

/* States of an instance (FMI 2.0, section 4.2.4); no step is ever in progress, discarded or cancelled. */
typedef enum { INSTANTIATED = 1, INITIALIZING, STEPPING, TERMINATED, FAILED } Phase;

/* What a host calls, by the rows of the table in call_order.c. */
typedef enum { SETUP_EXPERIMENT, ENTER_INITIALIZATION, EXIT_INITIALIZATION, DO_STEP, TERMINATE, GET, SET } Call;

/* A saved state: the bytes that are serialised, but for the digest at their end. A host gets its address. */
typedef struct State {
    struct State *next;
    size_t size;
    unsigned char *bytes;
} State;

typedef struct Instance {
    Component component;
    Memory memory; /* of the instance itself: its name and values */
    fmi2CallbackFunctions host;
    char *name;    /* as the host wrote it */
    Phase phase;
    int set_up;    /* whether fmi2SetupExperiment has been called */
    int ends;      /* whether the experiment has a stop time */
    double stop;   /* s */
    double present;    /* s, the communication point that the model has reached */
    double fixed_step; /* s, the only step accepted since the start; 0: none */
    double length;     /* s, of all steps, where the first one sets it; 0: no step was made */
    int started;       /* the model has started with the present parameters and inputs */
    int stale;         /* outputs on demand are older than the state */
    int inputs_set;    /* since outputs that follow inputs were computed */
    State *states;
    char failure[REASON_SIZE]; /* why the phase is FAILED */
} Instance;

/* messages.c */
void log_to_host(const fmi2CallbackFunctions *host, fmi2String name, fmi2Status status, const char *format, ...);
/* Log "call: why", stop the instance, and return fmi2Error. */
fmi2Status refuse_call(Instance *instance, const char *call, const char *format, ...);
/* The same for what the model refused, whose state is unknown then. */
fmi2Status refuse_for_model(Instance *instance, const char *call);
int is_utf8(const char *text);
void replace_bytes_not_utf8(char *text);

/* call_order.c: fmi2OK, or fmi2Error after a refusal. */
fmi2Status check_order(Instance *instance, Call call, const char *name);

/* communication_points.c: returns 0, and writes why a step is refused; else 1, and the length to step by. */
int admit_step(Instance *instance, double time, double step, double *length, char reason[REASON_SIZE]);

/* port_values.c */
void set_start_values(Component *component);
const Port *port_at(Kind kind, int place);
const char *variable_name(const Port *port, int place, char name[REASON_SIZE]);
/* Whether a value of a port may be set; `why` is written if not. */
int acceptable(const Port *port, double value, char why[REASON_SIZE]);
/* The first real output that is not finite, or -1. */
int output_not_finite(const Component *component);
void poison_outputs(Component *component);

/* model_calls.c */
/* Start the model: returns 0 with component.message, or 1. */
int start_component(Instance *instance);
/* The others return fmi2OK, or fmi2Error after a refusal. Start unless started with the present parameters and inputs: */
fmi2Status start_model(Instance *instance, const char *call);
/* Compute outputs that are on demand, or follow inputs, if one with these flags is read: */
fmi2Status compute_outputs(Instance *instance, const char *call, int flags);
fmi2Status check_outputs(Instance *instance, const char *call);

/* saved_state.c */
size_t saved_size(const Instance *instance);
void save(const Instance *instance, unsigned char *bytes);
/* Restore what was saved by an instance of this FMU: 1, or 0 with the reason. `model`: the model refused it. */
int restore(Instance *instance, const unsigned char *bytes, size_t size, char reason[REASON_SIZE], int *model);
/* Whether bytes without their digest are a saved state of this FMU. */
int is_saved_state(const unsigned char *bytes, size_t size, char reason[REASON_SIZE]);
#define DIGEST_SIZE 8
void digest_of(const unsigned char *bytes, size_t size, unsigned char digest[DIGEST_SIZE]);

/* fmi2_states.c */
void free_states(Instance *instance);

#endif
