/* The first half of the variables are inputs, the second half outputs of the same types: what comes in goes out. */

#include <string.h>

#include "model.h"

const char *model_open(State *state, const char *resources) {
    (void)state; (void)resources;
    return NULL;
}

void model_initialise(State *state) { model_step(state, 0, NULL); }

Outcome model_step(State *state, double step, const char **message) {
    (void)step; (void)message;
    static const size_t SIZES[] = {4, 8, 1, 2, 4, 8, 1, 2, 4, 8, sizeof(BOOL), TEXT};
    char *base = (char *)&state->values;
    for (size_t k = 0; k < COUNT / 2; k++) {
        const Variable *from = VARIABLES + k, *to = from + COUNT / 2;
        memcpy(base + to->offset, base + from->offset, from->count * SIZES[from->kind]);
    }
    return DONE;
}
