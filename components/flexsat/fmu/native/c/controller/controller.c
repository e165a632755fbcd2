/* The flight controller as a component: the twin of fmu/python/controller.py. */
#include <string.h>

#include "component.h"
#include "controller_law.h"
#include "controller_saved.h"
#include "periods.h"
#include "plain_component.h"

typedef struct Controller {
    PreparedController prepared;
    int64_t calls; /* to a period */
} Controller;

static ControllerState *state_of(const Component *component)
{
    return (ControllerState *)(void *)component->state;
}

/* Sample the design for the parameters, and plan the slew. */
int component_start(Component *component)
{
    Memory *memory = &component->memory;
    Controller *controller = memory_take(memory, 1, sizeof *controller);
    const ControllerData *matrices;
    ControllerParameters parameters;

    if (memory->failed || controller_parameters(component, &matrices, &parameters))
        return 1;
    if (prepare_controller(component, matrices, &parameters, &controller->prepared))
        return 1;
    controller->calls = 1;
    component->own = controller;
    component->step_length = 0.0;
    component->state_size = controller_state_size(&controller->prepared);
    component->state = memory_take(memory, 1, component->state_size);
    if (memory->failed)
        return 1;
    return controller_init(component, &controller->prepared, component->real + PORT_COMMAND_ROTATION,
                           component->real[PORT_COMMAND_START_TIME], state_of(component));
}

/* Divide the period into steps of this length. */
int component_first_step(Component *component, double length)
{
    Controller *controller = component->own;
    const double period = controller->prepared.period;
    const int64_t calls = whole_multiple(period, length);

    if (calls == 0)
        return refuse(component,
                      "a step of %g s is not accepted; the controller samples every %g s, which its gains were "
                      "designed for: step it with that, or with a whole fraction of it, such as %g s",
                      length, period, period / 5.0);
    controller->calls = calls;
    component->step_length = length;
    return 0;
}

/* If a sample is due, use the measurements at `time`; the torque holds from `time` to the next sample. */
int component_advance(Component *component, double time, double step)
{
    const Controller *controller = component->own;
    ControllerState *state = state_of(component);
    double *real = component->real;
    const int *boolean = component->boolean;
    Measurements measured;
    ControllerOutputs outputs;

    (void)step;
    if (!controller_is_due(state, controller->calls))
        return 0;
    if (command(component, &controller->prepared, &state->commanded, time, real + PORT_COMMAND_ROTATION,
                real[PORT_COMMAND_START_TIME]))
        return 1;
    measured.gyro_rate = real + PORT_GYRO_RATE;
    measured.accelerometer = real + PORT_ACCELEROMETER_ACCELERATION;
    measured.encoder_speed = real + PORT_ENCODER_SPEED;
    measured.encoder_angle = real + PORT_ENCODER_ANGLE;
    measured.star_tracker_mrp = real + PORT_STAR_TRACKER_MRP;
    measured.star_tracker_valid = boolean[PORT_STAR_TRACKER_VALID];
    measured.applied_torque = real + PORT_APPLIED_WHEEL_TORQUE;
    measured.applied_valid = boolean[PORT_APPLIED_VALID];
    /* the ports of reference and estimate stand in the order of the linear state */
    outputs.torque = real + PORT_WHEEL_TORQUE;
    outputs.estimate = real + PORT_ESTIMATE_MRP;
    outputs.reference = real + PORT_REFERENCE_MRP;
    outputs.reference_torque = real + PORT_REFERENCE_TORQUE;
    outputs.slow_errors = real + PORT_ESTIMATE_DISTURBANCE;
    return controller_step(component, &controller->prepared, state, time, &measured, &outputs);
}

int component_restored(Component *component)
{
    const Controller *controller = component->own;

    if (!is_reachable(&controller->prepared, state_of(component)))
        return refuse(component, "the saved state is none that a controller reaches");
    return component->step_length > 0.0 ? component_first_step(component, component->step_length) : 0;
}
