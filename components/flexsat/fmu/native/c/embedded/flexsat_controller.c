/* The flight controller without FMI: the five functions of the generated flexsat_controller.h. */
#include "flexsat_controller.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "caller_memory.h"
#include "controller_law.h"
#include "controller_saved.h"
#include "parameter_table.h"
#include "parameter_values.h"
#include "slew_plans.h"

#define NANOSECONDS 1e9 /* in a second */

enum { MOST_WHOLE_DELAY = 8 }; /* periods of both delays together: twice 20 ms */

struct FlexsatController {
    Component component;
    PreparedController prepared;
    ControllerState *state, *restored; /* the second one is filled and checked before it replaces the first */
    size_t state_size;  /* bytes, of each */
    double nanoseconds; /* of a period: a whole number, so that times are those of a clock that counts */
    uint64_t identity;  /* of design and parameters */
};

typedef struct SavedHead {
    uint64_t identity, size, sum;
} SavedHead;

/* Not more than FLEXSAT_STATE_SIZE is ever saved: else this does not compile. */
typedef char saved_state_fits[FLEXSAT_STATE_SIZE >= sizeof(SavedHead) + sizeof(ControllerState) +
                                                         (MOST_WHOLE_DELAY + 2) * WHEELS * sizeof(Real)
                                  ? 1
                                  : -1];

/* FNV-1a, 64 bits, continued from a sum. */
static uint64_t digest(uint64_t sum, const void *from, size_t size)
{
    const unsigned char *bytes = from;
    size_t k;

    for (k = 0; k < size; k++)
        sum = (sum ^ bytes[k]) * UINT64_C(0x100000001b3);
    return sum;
}

static int are_finite(int count, const Real *values)
{
    int k;

    for (k = 0; k < count; k++)
        if (!(fabs((double)values[k]) <= DBL_MAX))
            return 0;
    return 1;
}

static int is_finite_direction(const double values[3])
{
    return fabs(values[0]) <= DBL_MAX && fabs(values[1]) <= DBL_MAX && fabs(values[2]) <= DBL_MAX;
}

static int are_inputs(const FlexsatInputs *inputs)
{
    return are_finite(GYROS, inputs->gyro_rate) && are_finite(ACCELEROMETERS, inputs->accelerometer_acceleration) &&
           are_finite(WHEELS, inputs->encoder_speed) && are_finite(WHEELS, inputs->encoder_angle) &&
           is_finite_direction(inputs->star_tracker_mrp) && is_finite_direction(inputs->command_rotation) &&
           fabs(inputs->command_start_time) <= DBL_MAX &&
           (!inputs->applied_valid || are_finite(WHEELS, inputs->applied_wheel_torque));
}

/* Read and check the parameters, sample the design for them and take memory for the state. */
static int prepare(FlexsatController *controller, const FlexsatParameters *parameters)
{
    Component *component = &controller->component;
    Memory *memory = &component->memory;
    const size_t reals = (size_t)value_counts.reals, booleans = (size_t)value_counts.booleans;
    ControllerParameters checked;
    const ControllerData *matrices;

    component->real = memory_doubles(memory, reals);
    component->boolean = memory_take(memory, booleans, sizeof(int));
    component->string = memory_take(memory, (size_t)value_counts.texts, sizeof(char *));
    if (memory->failed || parameter_values(component, parameters) ||
        controller_parameters(component, &matrices, &checked) ||
        prepare_controller(component, matrices, &checked, &controller->prepared))
        return 1;
    controller->state_size = controller_state_size(&controller->prepared);
    controller->state = memory_take(memory, 1, controller->state_size);
    controller->restored = memory_take(memory, 1, controller->state_size);
    controller->nanoseconds = rint(controller->prepared.period * NANOSECONDS);
    controller->identity = digest(FLEXSAT_DESIGN, component->real, reals * sizeof(double));
    controller->identity = digest(controller->identity, component->boolean, booleans * sizeof(int));
    controller->identity = digest(controller->identity, &checked.guidance, sizeof checked.guidance);
    controller->identity = digest(controller->identity, &checked.replans, sizeof checked.replans);
    return memory->failed;
}

FlexsatController *flexsat_prepare(const FlexsatParameters *parameters, void *memory, size_t size,
                                   const char **reason)
{
    static const char *const no_memory = "the memory is too small, or not aligned as a double is";
    Memory given;
    FlexsatController *controller;

    *reason = no_memory;
    if (memory_given(&given, memory, size))
        return NULL;
    controller = memory_take(&given, 1, sizeof *controller);
    if (controller == NULL)
        return NULL;
    controller->component.memory = given;
    if (prepare(controller, parameters)) {
        if (controller->component.message[0] != '\0')
            *reason = controller->component.message;
        return NULL;
    }
    *reason = controller->component.message;
    return controller;
}

FlexsatStatus flexsat_init(FlexsatController *controller, const double rotation[3], double start_time)
{
    controller->component.message[0] = '\0';
    memset(controller->state, 0, controller->state_size);
    if (!is_finite_direction(rotation) || !(fabs(start_time) <= DBL_MAX)) {
        refuse(&controller->component, "command_rotation and command_start_time must be finite");
        return FLEXSAT_BAD_INPUT;
    }
    if (controller_init(&controller->component, &controller->prepared, rotation, start_time, controller->state))
        return FLEXSAT_FAILED;
    return FLEXSAT_OK;
}

FlexsatStatus flexsat_step(FlexsatController *controller, const FlexsatInputs *inputs, FlexsatOutputs *outputs)
{
    Component *component = &controller->component;
    ControllerState *state = controller->state;
    const double time = (double)state->count * controller->nanoseconds / NANOSECONDS;
    Measurements measured;
    ControllerOutputs commanded;
    FlexsatReal slow_errors[SLOW];
    int refused;

    component->message[0] = '\0';
    if (!are_inputs(inputs)) {
        refuse(component, "an input is not finite");
        return FLEXSAT_BAD_INPUT;
    }
    refused = command(component, &controller->prepared, &state->commanded, time, inputs->command_rotation,
                      inputs->command_start_time);
    measured.gyro_rate = inputs->gyro_rate;
    measured.accelerometer = inputs->accelerometer_acceleration;
    measured.encoder_speed = inputs->encoder_speed;
    measured.encoder_angle = inputs->encoder_angle;
    measured.star_tracker_mrp = inputs->star_tracker_mrp;
    measured.star_tracker_valid = inputs->star_tracker_valid != 0;
    measured.applied_torque = inputs->applied_wheel_torque;
    measured.applied_valid = inputs->applied_valid != 0;
    commanded.torque = outputs->wheel_torque;
    commanded.estimate = outputs->estimate;
    commanded.reference = outputs->reference;
    commanded.reference_torque = outputs->reference_torque;
    commanded.slow_errors = slow_errors;
    if (controller_step(component, &controller->prepared, state, time, &measured, &commanded))
        return FLEXSAT_FAILED;
    memcpy(outputs->estimate_disturbance, slow_errors, sizeof outputs->estimate_disturbance);
    memcpy(outputs->estimate_gyro_bias, slow_errors + TORQUES, sizeof outputs->estimate_gyro_bias);
    return refused ? FLEXSAT_COMMAND_REFUSED : FLEXSAT_OK;
}

void flexsat_save(const FlexsatController *controller, unsigned char bytes[FLEXSAT_STATE_SIZE])
{
    SavedHead head;

    head.identity = controller->identity;
    head.size = controller->state_size;
    head.sum = digest(controller->identity, controller->state, controller->state_size);
    memset(bytes, 0, FLEXSAT_STATE_SIZE);
    memcpy(bytes, &head, sizeof head);
    memcpy(bytes + sizeof head, controller->state, controller->state_size);
}

FlexsatStatus flexsat_restore(FlexsatController *controller, const unsigned char bytes[FLEXSAT_STATE_SIZE])
{
    Component *component = &controller->component;
    const unsigned char *saved = bytes + sizeof(SavedHead);
    SavedHead head;

    component->message[0] = '\0';
    memcpy(&head, bytes, sizeof head);
    if (head.identity != controller->identity || head.size != controller->state_size) {
        refuse(component, "the saved state is that of another design, or of other parameters");
        return FLEXSAT_FAILED;
    }
    if (head.sum != digest(head.identity, saved, controller->state_size)) {
        refuse(component, "the saved state is damaged");
        return FLEXSAT_FAILED;
    }
    memcpy(controller->restored, saved, controller->state_size);
    if (!is_reachable(&controller->prepared, controller->restored)) {
        refuse(component, "the saved state is none that a controller reaches");
        return FLEXSAT_FAILED;
    }
    memcpy(controller->state, controller->restored, controller->state_size);
    return FLEXSAT_OK;
}
