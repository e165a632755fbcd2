/* What the FMI layer needs of a component: plant.c, sensors.c and controller.c each define these functions once.

The values of ports lie in arrays, by their places: the generated ports.h names them. A component reads its inputs and
parameters there, and writes its outputs. What a run changes beyond these lies in one block, `state`, without pointers
in it, so that saving is copying. Everything else is computed by component_start and changes no more.

Each function returns 0, or another number if it refuses; then `message` says why, in one line. */
#ifndef FLEXSAT_COMPONENT_H
#define FLEXSAT_COMPONENT_H

#include <stddef.h>

#include "memory.h"

#define MESSAGE_SIZE 512
#define STRING_SIZE 256 /* bytes of a string port, the zero at its end included */

typedef struct Component {
    double *real;         /* by places; these arrays are the FMI layer's */
    int *integer;
    int *boolean;         /* 0 or 1 */
    char **string;        /* each STRING_SIZE bytes, to be written in place */
    Memory memory;        /* of what component_start makes; emptied before it runs again */
    unsigned char *state; /* from `memory`, set by component_start */
    size_t state_size;    /* bytes */
    double start_time;    /* s, of the experiment */
    double step_length;   /* s: the only one accepted, set by component_start or component_first_step; 0: any */
    void *own;            /* from `memory`: prepared arrays, buffers and views of the state */
    char message[MESSAGE_SIZE];
} Component;

/* Prepare for the parameters and make the state at the start of a run; the outputs are true afterwards. Allocates from
`memory`, as component_tuned may; no other function does. May be called again during initialisation. */
int component_start(Component *component);

/* Where all steps have to be as long as the first: prepare for this length [s]. */
int component_first_step(Component *component, double length);

/* Step from `time` to `time + step` [s]. */
int component_advance(Component *component, double time, double step);

/* A tunable parameter has changed. */
int component_tuned(Component *component);

/* Compute the outputs that follow inputs from the present state and inputs. */
int component_follow_inputs(Component *component);

/* Only of a component with outputs that follow inputs: their derivatives in the direction of inputs `seed`. Both arrays
have a place for each real; `change` is 0 before, and gets the derivatives. At a kink they are those of the side that
the direction points to. */
int component_differentiate(Component *component, const double *seed, double *change);

/* Compute the outputs on demand. */
int component_evaluate(Component *component);

/* The state, the values and the step length were replaced by saved ones: renew what is derived from them. */
int component_restored(Component *component);

/* Write the reason for a refusal, printf-like; returns 1. */
int refuse(Component *component, const char *format, ...);

#endif
