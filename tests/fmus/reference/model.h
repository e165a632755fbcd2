/* What a model is, whatever the version of FMI around it: its variables in a struct, and three functions.

   `variables.h` is written by build.py from the same table as the model description: the struct Values, the array
   VARIABLES that says where each variable lies in it, COUNT, and DEFAULTS, the start values. */

#ifndef MODEL_H
#define MODEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define TEXT 8192 /* bytes of a String, its end included */

typedef enum {
    FLOAT32, FLOAT64, INT8, INT16, INT32, INT64, UINT8, UINT16, UINT32, UINT64, BOOLEAN, STRING
} Kind;

typedef char Text[TEXT];

typedef struct {
    Kind kind;
    size_t offset; /* in Values */
    size_t count;  /* of its elements */
} Variable;

#include "variables.h"

typedef struct {
    Values values;
    double time;
    int steps;
} State; /* plain memory: saving it is copying it */

/* Results of a step: END is an end that the model asks for instead of the step, LAST one after it. */
typedef enum { DONE, END, LAST, EARLY, EVENT, FAILED, BROKEN, RAW = 1000 } Outcome; /* RAW + s: the status s itself */

const char *model_open(State *state, const char *resources); /* a path; returns what went wrong, or NULL */
void model_initialise(State *state);
Outcome model_step(State *state, double step, const char **message);

/* Return where a variable of this kind lies, or NULL if there is none. */
static inline void *model_value(State *state, unsigned reference, Kind kind) {
    if (reference >= COUNT || VARIABLES[reference].kind != kind) return NULL;
    return (char *)&state->values + VARIABLES[reference].offset;
}

/* Step from a time on, and count. */
static inline Outcome model_advance(State *state, double time, double step, const char **message) {
    state->time = time;
    Outcome outcome = model_step(state, step, message);
    state->steps++;
    return outcome;
}

#endif
