#include "bearing_friction.h"

#include <string.h>

#include "linear_algebra.h"

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
        response[j * b + j] += prepared->length / motion->matrices.data->wheel_inertia;
    }
    invert(b, response, prepared->torque_of_speed);
}

void add_friction(Plant *plant, const double *limits, const double *end)
{
    const Motion *motion = &plant->motion;
    const PlantStep *prepared = plant->step;
    const PlantState *state = &plant->state;
    const double inertia = motion->matrices.data->wheel_inertia;
    double *speed = plant->work.seen, *mount = plant->work.unbraked, *torque = plant->work.given;
    int b = prepared->braked, i, j;

    memset(speed, 0, (size_t)motion->speeds * sizeof(double));
    panels_add_times(&motion->speed, end, speed);
    add_times_vector(motion->speeds, motion->loads.count, prepared->end_of_load, state->load, speed);
    add_times_vector(6, 6, motion->compliance, state->momentum, speed);
    sparse_times(&motion->mount_speed, speed, mount);
    for (i = 0; i < motion->matrices.wheels; i++)
        mount[i] += (state->axial[i] + prepared->length * torque[i]) / inertia;
    for (i = 0; i < b; i++) {
        const double limit = limits[prepared->wheel[i]];
        double braking = 0.0;
        for (j = 0; j < b; j++)
            braking -= prepared->torque_of_speed[i * b + j] * mount[prepared->wheel[j]];
        if (braking > limit)
            braking = limit;
        if (braking < -limit)
            braking = -limit;
        torque[prepared->wheel[i]] += braking;
    }
}
