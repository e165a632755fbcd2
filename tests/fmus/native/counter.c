/* The toy of tests/fmus/toys/counter.py as a native component: all kinds of ports, noise, an output on demand. */
#include "component.h"
#include "ports.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct Own {
    int evaluations; /* like the Python toy's, no part of the state */
} Own;

typedef struct State {
    double level[3];
    double recent[4];
    unsigned noise;
    int steps;
} State;

/* A number between -1 and 1 that looks random. */
static double draw(State *state)
{
    state->noise = state->noise * 1664525u + 1013904223u;
    return (double)state->noise / 2147483648.0 - 1.0;
}

int component_start(Component *component)
{
    State *state;
    int k;

    if (strcmp(component->string[PORT_LABEL], "refuse") == 0)
        return refuse(component, "label must not be 'refuse'");
    component->own = memory_take(&component->memory, 1, sizeof(Own));
    state = memory_take(&component->memory, 1, sizeof(State));
    if (component->memory.failed)
        return refuse(component, "no memory");
    component->state = (unsigned char *)state;
    component->state_size = sizeof(State);
    state->noise = (unsigned)component->integer[PORT_SEED];
    for (k = 0; k < 3; k++)
        component->real[PORT_LEVEL + k] = state->level[k] = component->real[PORT_GAIN];
    return 0;
}

int component_first_step(Component *component, double length)
{
    component->step_length = length;
    return 0;
}

int component_advance(Component *component, double time, double step)
{
    State *state = (State *)component->state;
    double mean = 0.0;
    int k;

    if (component->boolean[PORT_EXPLODE])
        return refuse(component, "asked to at 100%% of %g s", time);
    state->recent[state->steps % 4] = draw(state);
    for (k = 0; k < 4; k++)
        mean += 0.25 * state->recent[k];
    for (k = 0; k < 3; k++) {
        const double torque = component->real[PORT_WHEEL_TORQUE + k];
        state->level[k] += step * (2.0 * torque + component->real[PORT_GAIN] * mean);
        component->real[PORT_LEVEL + k] = state->level[k];
    }
    state->steps++;
    component->real[PORT_ANGLE] = component->real[PORT_POISON] > 0.5 ? nan("") : time + step;
    component->boolean[PORT_VALID] = 1;
    snprintf(component->string[PORT_GREETING], STRING_SIZE, "%.200s %d", component->string[PORT_LABEL], state->steps);
    return 0;
}

int component_tuned(Component *component)
{
    (void)component;
    return 0;
}

int component_follow_inputs(Component *component)
{
    (void)component;
    return 0;
}

int component_evaluate(Component *component)
{
    const State *state = (const State *)component->state;
    Own *own = component->own;
    double sum = 0.0;
    int k;

    for (k = 0; k < 3; k++)
        sum += state->level[k] * state->level[k];
    own->evaluations++;
    component->real[PORT_ENERGY] = sum;
    component->integer[PORT_EVALUATIONS] = own->evaluations;
    return 0;
}

int component_restored(Component *component)
{
    const State *state = (const State *)component->state;

    if (state->steps < 0 || state->steps > 1000000000)
        return refuse(component, "the saved state has %d steps, which no run has", state->steps);
    return 0;
}
