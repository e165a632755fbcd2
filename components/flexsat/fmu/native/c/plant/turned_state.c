/* Turning is quasi-static: the motion of the drive itself, and its torque, are not modelled. */
#include "turned_state.h"

#include <string.h>

#include "linear_algebra.h"
#include "plant_telemetry.h"
#include "ports.h"

int take_kept(Memory *memory, int modes, int angles, Kept *kept)
{
    const size_t size = 6 + (size_t)modes;

    kept->angle = memory_doubles(memory, (size_t)angles);
    kept->eta = memory_doubles(memory, angles > 0 ? size : 0);
    kept->momenta = memory_doubles(memory, angles > 0 ? size : 0);
    kept->motion = memory_doubles(memory, angles > 0 ? size : 0);
    kept->mass = memory_doubles(memory, angles > 0 ? size * size : 0);
    return memory->failed;
}

void keep_motion(const Plant *plant, Kept *kept)
{
    const Motion *motion = &plant->motion;
    const int m = motion->matrices.modes;
    double body[6], *speed = kept->motion + 6;
    int i, j;

    structure_of(&motion->free, motion->free.displacement, plant->state.z, kept->eta);
    structure_of(&motion->free, motion->free.velocity, plant->state.z, speed);
    times_vector(6, 6, motion->compliance, plant->state.momentum, body);
    for (i = 0; i < 6; i++)
        for (j = 0; j < m; j++)
            body[i] -= motion->carried[i * m + j] * speed[j];
    memcpy(kept->momenta, plant->state.momentum, 6 * sizeof(double));
    for (i = 0; i < m; i++) {
        kept->momenta[6 + i] = speed[i];
        for (j = 0; j < 6; j++)
            kept->momenta[6 + i] += motion->mass[(6 + i) * (6 + m) + j] * body[j];
    }
    memset(kept->wheels, 0, sizeof kept->wheels);
    add_wheels(plant, kept->eta, kept->wheels);
}

void continue_motion(Component *component, Plant *plant, Kept *kept)
{
    const Motion *motion = &plant->motion;
    const int m = motion->matrices.modes, size = 6 + m;
    double wheels[3] = {0.0, 0.0, 0.0};
    int i;

    add_wheels(plant, kept->eta, wheels);
    for (i = 0; i < 3; i++)
        kept->momenta[3 + i] += kept->wheels[i] - wheels[i];
    memcpy(kept->mass, motion->mass, (size_t)size * (size_t)size * sizeof(double));
    memcpy(kept->motion, kept->momenta, (size_t)size * sizeof(double));
    solve(size, 1, kept->mass, kept->motion); /* which is regular: it is positive definite */
    plant_place(plant, kept->eta, kept->motion, kept->motion + 6);
    memcpy(plant->state.momentum, kept->momenta, 6 * sizeof(double));
    plant_feed_through(component, plant);
    memcpy(plant->state.turn, plant->work.turn, 3 * sizeof(double));
    memcpy(plant->state.speed, component->real + PORT_WHEEL_SPEED, (size_t)motion->matrices.wheels * sizeof(double));
}
