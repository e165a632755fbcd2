/* A ball that falls and bounces; the bounces within a step are found and passed exactly. */

#include <math.h>

#include "model.h"

const char *model_open(State *state, const char *resources) {
    (void)state; (void)resources;
    return NULL;
}

void model_initialise(State *state) {
    state->values.h = state->values.h0;
    state->values.v = 0;
    state->values.bounces = 0;
}

Outcome model_step(State *state, double step, const char **message) {
    (void)message;
    Values *s = &state->values;
    double left = step, now = state->time, g = s->g;
    while (s->v != 0 || s->h > 0) {
        double hit = (s->v + sqrt(s->v * s->v + 2 * g * s->h)) / g; /* from now */
        if (hit > left) break;
        left -= hit;
        now += hit;
        s->v = s->e * (g * hit - s->v);
        s->h = 0;
        s->bounces++;
        s->last_bounce = now;
        if (s->v < s->v_min) s->v = 0; /* it comes to rest */
    }
    if (s->v != 0 || s->h > 0) {
        s->h += left * (s->v - 0.5 * g * left);
        s->v -= g * left;
    }
    return DONE;
}
