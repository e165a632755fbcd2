/* Put out the numbers of resources/numbers.txt: how many there are, and at each step the next one. */

#include <stdio.h>
#include <string.h>

#include "model.h"

const char *model_open(State *state, const char *resources) {
    char path[4096];
    snprintf(path, sizeof path, "%s%snumbers.txt", resources, resources[strlen(resources) - 1] == '/' ? "" : "/");
    FILE *file = fopen(path, "r");
    if (!file) return "cannot open numbers.txt of its resources";
    Values *v = &state->values;
    v->count = 0;
    while (v->count < 8 && fscanf(file, "%lf", &v->numbers[v->count]) == 1) v->count++;
    fclose(file);
    return NULL;
}

void model_initialise(State *state) { state->values.number = 0; }

Outcome model_step(State *state, double step, const char **message) {
    (void)step; (void)message;
    Values *v = &state->values;
    v->number = v->numbers[state->steps % v->count];
    return DONE;
}
