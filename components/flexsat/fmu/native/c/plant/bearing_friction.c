#include "bearing_friction.h"

#include <string.h>

#include "linear_algebra.h"

double change_within(double value, double least, double most, double change)
{
    if (value > most || (value == most && change > 0.0) || value < least || (value == least && change < 0.0))
        return 0.0;
    return change;
}

void prepare_friction(Plant *plant, const double *limits)
{
    const Motion *motion = &plant->motion;
    PlantStep *prepared = plant->step;
    const int n = motion->matrices.wheels, r = motion->loads.count, speeds = motion->speeds;
    double *response = plant->work.response;
    double *speed = plant->work.seen, *mount = plant->work.unbraked;
    int b = 0, i, j, l;

    for (i = 0; i < n; i++)
        if (limits[i] > 0.0)
            prepared->wheel[b++] = i;
    prepared->braked = b;
    for (j = 0; j < b; j++) { /* speeds at the end of a step by a torque of 1 N.m on wheel j */
        for (i = 0; i < speeds; i++) {
            speed[i] = 0.0;
            for (l = 0; l < r; l++)
                speed[i] += prepared->end_of_load[i * r + l] *
                            motion->loads.of_held[l * motion->loads.held + prepared->wheel[j]];
        }
        sparse_times(&motion->mount_speed, speed, mount);
        for (i = 0; i < b; i++)
            response[i * b + j] = mount[prepared->wheel[i]];
        response[j * b + j] += prepared->length / motion->matrices.data->wheel_inertia[prepared->wheel[j]];
    }
    invert(b, response, prepared->torque_of_speed);
}

/* Find the torques, (b), that bring the wheels with friction to rest at the end of a step, from loads (r) and torques
(n). Without `end`, which is z of the step's end without loads: what changes of loads and torques change in them. */
static void holding_torques(Plant *plant, const double *end, const double *load, const double *torque, double *holding)
{
    const Motion *motion = &plant->motion;
    const PlantStep *prepared = plant->step;
    const PlantState *state = &plant->state;
    const double *inertia = motion->matrices.data->wheel_inertia;
    double *speed = plant->work.seen, *mount = plant->work.unbraked;
    const int b = prepared->braked;
    int i, j;

    memset(speed, 0, (size_t)motion->speeds * sizeof(double));
    if (end != NULL)
        panels_add_times(&motion->speed, end, speed);
    add_times_vector(motion->speeds, motion->loads.count, prepared->end_of_load, load, speed);
    if (end != NULL)
        add_times_vector(6, 6, motion->compliance, state->momentum, speed);
    sparse_times(&motion->mount_speed, speed, mount);
    for (i = 0; i < motion->matrices.wheels; i++)
        mount[i] += ((end != NULL ? state->axial[i] : 0.0) + prepared->length * torque[i]) / inertia[i];
    for (i = 0; i < b; i++) {
        holding[i] = 0.0;
        for (j = 0; j < b; j++)
            holding[i] -= prepared->torque_of_speed[i * b + j] * mount[prepared->wheel[j]];
    }
}

void add_friction(Plant *plant, const double *limits, const double *end)
{
    const PlantStep *prepared = plant->step;
    double *torque = plant->work.given, *holding = plant->work.holding;
    int i;

    holding_torques(plant, end, plant->state.load, torque, holding);
    for (i = 0; i < prepared->braked; i++) {
        const double limit = limits[prepared->wheel[i]];
        double braking = holding[i];
        if (braking > limit)
            braking = limit;
        if (braking < -limit)
            braking = -limit;
        torque[prepared->wheel[i]] += braking;
    }
}

void add_friction_change(Plant *plant, const double *limits, const double *end, const double *load,
                         const double *load_change, double *torque_change)
{
    const PlantStep *prepared = plant->step;
    double *holding = plant->work.holding, *change = holding + plant->motion.matrices.wheels;
    int i;

    holding_torques(plant, end, load, plant->work.given, holding);
    holding_torques(plant, NULL, load_change, torque_change, change);
    for (i = 0; i < prepared->braked; i++)
        torque_change[prepared->wheel[i]] += change_within(holding[i], -limits[prepared->wheel[i]], limits[prepared->wheel[i]], change[i]);
}
