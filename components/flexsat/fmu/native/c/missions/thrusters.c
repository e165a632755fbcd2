/* Thrusters as a component: the twin of fmu/python/thrusters.py. */
#include <string.h>

#include "plain_component.h"
#include "ports.h"
#include "random.h"
#include "thruster_model.h"

#define STREAM 3 /* of this component's noise */

typedef struct ThrustersState {
    ThrusterState model;
    Random noise;
} ThrustersState;

static ThrustersState *state_of(const Component *component) { return (ThrustersState *)(void *)component->state; }

static void write_outputs(Component *component, const double *thrust)
{
    const PreparedThrusters *prepared = component->own;
    const ThrusterState *state = &state_of(component)->model;
    double *real = component->real;
    int i, k;

    for (i = 0; i < 3; i++) {
        double force = 0.0, torque = 0.0;
        for (k = 0; k < THRUSTERS; k++) {
            force += prepared->wrench[i][k] * thrust[k];
            torque += prepared->wrench[3 + i][k] * thrust[k];
        }
        real[PORT_EXTERNAL_FORCE + i] = real[PORT_DISTURBANCE_FORCE + i] + force;
        real[PORT_EXTERNAL_TORQUE + i] = real[PORT_DISTURBANCE_TORQUE + i] + torque;
        real[PORT_THRUST_ANGULAR_IMPULSE + i] = state->angular_impulse[i];
    }
    memcpy(real + PORT_THRUST, thrust, THRUSTERS * sizeof(double));
    real[PORT_THRUST_IMPULSE] = state->impulse;
    for (k = 0; k < THRUSTERS; k++)
        component->integer[PORT_THRUST_PULSES + k] = (int)state->pulses[k];
}

static int prepare(Component *component, double step)
{
    PreparedThrusters *prepared = component->own;

    prepared->noise = component->real[PORT_THRUST_NOISE];
    return prepare_thrusters(component, step, prepared);
}

int component_start(Component *component)
{
    const double closed[THRUSTERS] = {0.0};

    if (take_component_memory(component, sizeof(PreparedThrusters), sizeof(ThrustersState))
        || prepare(component, component->real[PORT_THRUST_PERIOD]))
        return 1;
    random_begin(&state_of(component)->noise, (uint64_t)component->integer[PORT_SEED], STREAM, 0);
    write_outputs(component, closed);
    return 0;
}

/* Divide the period into steps of this length. */
int component_first_step(Component *component, double length)
{
    if (prepare(component, length))
        return 1;
    component->step_length = length;
    return 0;
}

/* Sample the commands where a period begins; the outputs are means from now over the step. */
int component_advance(Component *component, double time, double step)
{
    const PreparedThrusters *prepared = component->own;
    ThrustersState *state = state_of(component);
    double draw[THRUSTERS] = {0.0}, thrust[THRUSTERS];
    int k;

    (void)time;
    (void)step;
    if (thrusters_begin_a_period(prepared, &state->model))
        for (k = 0; k < THRUSTERS; k++)
            draw[k] = random_normal(&state->noise);
    step_thrusters(prepared, &state->model, component->real + PORT_THRUST_COMMAND, draw, thrust);
    write_outputs(component, thrust);
    return 0;
}

int component_restored(Component *component)
{
    if (component->step_length > 0.0 && prepare(component, component->step_length))
        return 1;
    if (!is_thruster_state(component->own, &state_of(component)->model))
        return refuse(component, "the saved state is none that thrusters reach");
    return 0;
}
