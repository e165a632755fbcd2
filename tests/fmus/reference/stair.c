/* Count steps. After `last` of them the model wants to end; `mode` makes its step number `at` something worse.

   A mode of 100 or above is a status that FMI may not know: 109 is -1, 110 is 0, 115 is 5. */

#include <math.h>
#include <stdlib.h>

#include "model.h"

enum { WELL, RETURNS_EARLY, WANTS_EVENT, NOT_A_NUMBER, FAILS, BREAKS, CRASHES, ENDS_AFTER };

const char *model_open(State *state, const char *resources) {
    (void)state; (void)resources;
    return NULL;
}

void model_initialise(State *state) { state->values.counter = 0; }

Outcome model_step(State *state, double step, const char **message) {
    (void)step;
    Values *v = &state->values;
    if (v->counter >= v->last) return END;
    v->counter++;
    v->height = 0.5 * v->counter;
    if (v->counter != v->at) return DONE;
    switch (v->mode) {
    case RETURNS_EARLY: return EARLY;
    case WANTS_EVENT: return EVENT;
    case NOT_A_NUMBER: v->height = NAN; return DONE;
    case FAILS: *message = "the stair has a broken step"; return FAILED;
    case BREAKS: *message = "the stair fell down"; return BROKEN;
    case ENDS_AFTER: return LAST;
    case CRASHES: *(volatile int *)NULL = 1;
    }
    if (v->mode >= 100) return (Outcome)(RAW + v->mode - 110);
    return DONE;
}
