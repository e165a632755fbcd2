/* Decay, x' = -k x, by the explicit Euler method with a step of its own: x falls by the factor 1 - 0.1 k in each. */

#include "model.h"

enum { PER_SECOND = 10 }; /* steps of its own */

const char *model_open(State *state, const char *resources) {
    (void)state; (void)resources;
    return NULL;
}

void model_initialise(State *state) { (void)state; }

Outcome model_step(State *state, double step, const char **message) {
    Values *v = &state->values;
    if (step <= 0) {
        *message = "the step must be > 0";
        return FAILED;
    }
    long done = (long)(state->time * PER_SECOND + 0.5);
    double end = (state->time + step) * PER_SECOND; /* a step of not-a-number has no end */
    while (!(done + 1 > end + 1e-6)) {
        v->x -= v->k * v->x / PER_SECOND;
        done++;
    }
    return DONE;
}
