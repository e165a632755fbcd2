/* dx/dt = u - rate x, solved exactly for an input held over each step. */

#include <math.h>

#include "model.h"

const char *model_open(State *state, const char *resources) {
    (void)state; (void)resources;
    return NULL;
}

void model_initialise(State *state) { state->values.x = state->values.x0; }

Outcome model_step(State *state, double step, const char **message) {
    (void)message;
    Values *v = &state->values;
    double kept = exp(-v->rate * step);
    v->x = kept * v->x - expm1(-v->rate * step) / v->rate * v->u;
    return DONE;
}
