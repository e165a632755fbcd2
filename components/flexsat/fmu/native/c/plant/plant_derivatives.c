#include "plant_derivatives.h"

#include <string.h>

#include "bearing_friction.h"
#include "motors.h"
#include "ports.h"

/* Set the present torques, limited, and the loads with them, as the friction finds them. */
static void set_present(const Component *component, Plant *plant)
{
    const Motion *motion = &plant->motion;
    double *given = plant->work.given, *load = plant->work.present_load;
    int i;

    memcpy(given, component->real + PORT_WHEEL_TORQUE, (size_t)motion->loads.inputs * sizeof(double));
    drive_motors(plant, given);
    sparse_times(&motion->load_of_input, given, load);
    for (i = 0; i < motion->loads.count; i++)
        load[i] += plant->state.internal[i];
}

void plant_differentiate(const Component *component, Plant *plant, const double *seed, double *change)
{
    const Motion *motion = &plant->motion;
    const double *torque = component->real + PORT_WHEEL_TORQUE;
    double least, most, *input_change = plant->work.input_change, *load_change = plant->work.load_change;
    int i;

    memcpy(input_change, seed + PORT_WHEEL_TORQUE, (size_t)motion->loads.inputs * sizeof(double));
    for (i = 0; i < motion->matrices.wheels; i++) { /* the steps of a motor's command are left out */
        motor_range(plant, i, &least, &most);
        input_change[i] = change_within(torque[i], least, most, input_change[i]);
    }
    sparse_times(&motion->load_of_input, input_change, load_change);
    if (plant->step->braked > 0) {
        set_present(component, plant);
        map_vector(&motion->free, &plant->step->whole, plant->state.z, plant->work.end);
        add_friction_change(plant, component->real + PORT_WHEEL_FRICTION_TORQUE, plant->work.end,
                            plant->work.present_load, load_change, input_change);
        sparse_times(&motion->load_of_input, input_change, load_change);
    }
    panels_add_times(&motion->acceleration, load_change, change + PORT_ACCELEROMETER_SITE_ACCELERATION);
}
