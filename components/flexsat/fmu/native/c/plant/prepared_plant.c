/* What does not depend on the output side; see plant_outputs.c for that. */
#include "prepared_plant.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "linear_algebra.h"
#include "number_text.h"
#include "plant_outputs.h"

static void disperse_mass(Motion *motion)
{
    const PlantParameters *given = &motion->parameters;
    const int size = 6 + motion->matrices.modes;
    double *mass = motion->mass;
    int i, j;

    memcpy(mass, motion->matrices.mass, (size_t)size * (size_t)size * sizeof(double));
    for (i = 0; i < 3; i++)
        mass[(3 + i) * size + 3 + i] += mass[(3 + i) * size + 3 + i] * given->inertia_dispersion[i];
    for (i = 0; i < 6; i++)
        for (j = 6; j < size; j++) {
            mass[i * size + j] *= 1.0 + given->participation_dispersion[j - 6];
            mass[j * size + i] = mass[i * size + j];
        }
}

static int refuse_mass(Component *component, const PlantParameters *given, int modes)
{
    const double *inertia = given->inertia_dispersion;
    char x[NUMBER_SIZE], y[NUMBER_SIZE], z[NUMBER_SIZE], participation[80] = "";
    double largest = -INFINITY;
    int any = 0, j;

    for (j = 0; j < modes; j++) {
        any |= given->participation_dispersion[j] != 0.0;
        if (given->participation_dispersion[j] > largest)
            largest = given->participation_dispersion[j];
    }
    if (any)
        snprintf(participation, sizeof participation, "dispersion.participation up to %g, ", largest);
    return refuse(component,
                  "%sdispersion.inertia = [%s, %s, %s]%s takes away more than the modes leave to the rigid body: the "
                  "mass matrix is not positive definite; choose larger values",
                  participation, number_text(inertia[0], x), number_text(inertia[1], y), number_text(inertia[2], z),
                  any ? "," : "");
}

/* Split the motion of body and structure: compliance, carried, and `effective` (m, m), the inverse of the modes' mass
with the body free. `work` holds (6 + m)^2 doubles. Returns 1 where the mass is not positive definite. */
static int split_body(Motion *motion, double *effective, double *work)
{
    const int m = motion->matrices.modes, size = 6 + m;
    const double *mass = motion->mass;
    double rigid[36];
    int i, j, k;

    memcpy(work, mass, (size_t)size * (size_t)size * sizeof(double));
    if (cholesky(size, work))
        return 1;
    for (i = 0; i < 6; i++)
        for (j = 0; j < 6; j++)
            rigid[6 * i + j] = mass[i * size + j];
    invert(6, rigid, motion->compliance);
    for (i = 0; i < 6; i++) /* (6, m) */
        for (j = 0; j < m; j++)
            work[i * m + j] = mass[i * size + 6 + j];
    times_matrix(6, 6, m, motion->compliance, work, motion->carried);
    for (i = 0; i < m; i++)
        for (j = 0; j < m; j++) {
            double element = mass[(size_t)(6 + i) * (size_t)size + (size_t)(6 + j)];
            for (k = 0; k < 6; k++)
                element -= mass[k * size + 6 + i] * motion->carried[k * m + j];
            work[(size_t)i * (size_t)m + (size_t)j] = element;
        }
    return invert(m, work, effective);
}

/* What acts on a part of one mode does so by one number, and then on both of its coordinates; `rows` is scratch. */
static void prepare_push(Motion *motion, const double *acceleration, double *rows)
{
    const FreeModes *free = &motion->free;
    const size_t r = (size_t)motion->loads.count;
    int i;

    memset(rows, 0, (size_t)free->modes * r * sizeof(double));
    for (i = 0; i < free->alone; i++) {
        const double *block = free->of_structure + 2 * free->place[i];
        memcpy(rows + (size_t)i * r, acceleration + (size_t)free->mode[i] * r, r * sizeof(double));
        motion->push_p[i] = block[1];
        motion->push_q[i] = block[3];
    }
    panels_fill(rows, &motion->push);
}

/* drive (2 m, r) */
static void prepare_drive(Motion *motion, const double *effective, double *on_modes, double *acceleration)
{
    const int m = motion->matrices.modes, r = motion->loads.count;
    const double *force = motion->loads.force;
    int i, j, k;

    for (i = 0; i < m; i++)
        for (j = 0; j < r; j++) {
            double element = force[(size_t)(6 + i) * (size_t)r + (size_t)j];
            for (k = 0; k < 6; k++)
                element -= motion->carried[k * m + i] * force[k * r + j];
            on_modes[(size_t)i * (size_t)r + (size_t)j] = element;
        }
    times_matrix(m, m, r, effective, on_modes, acceleration);
    coordinates_of(&motion->free, r, NULL, acceleration, motion->drive);
    prepare_push(motion, acceleration, on_modes);
}

int prepare_motion(Component *component, Motion *motion)
{
    Memory *memory = &component->memory;
    const PlantMatrices *matrices = &motion->matrices;
    const PlantParameters *given = &motion->parameters;
    MemoryBlock *mark;
    double *effective, *work, *on_modes;
    size_t m, r;
    int i;

    if (choose_matrices(component, &motion->matrices) ||
        read_parameters(component, matrices, &motion->parameters) ||
        prepare_loads(component, matrices, &motion->loads))
        return 1;
    m = (size_t)matrices->modes, r = (size_t)motion->loads.count;
    motion->speeds = 6 + motion->loads.turns;
    motion->mass = memory_doubles(memory, (6 + m) * (6 + m));
    motion->stiffness = memory_doubles(memory, m);
    motion->damping = memory_doubles(memory, m);
    motion->compliance = memory_doubles(memory, 36);
    motion->carried = memory_doubles(memory, 6 * m);
    motion->drive = memory_doubles(memory, 2 * m * r);
    motion->driven = memory_doubles(memory, 2 * m * r);
    motion->of_load = memory_doubles(memory, (size_t)motion->speeds * r);
    motion->push_p = memory_doubles(memory, m);
    motion->push_q = memory_doubles(memory, m);
    effective = memory_doubles(memory, m * m);
    if (memory->failed || panels_take(memory, (int)m, (int)r, &motion->push))
        return refuse(component, "there is not enough memory");
    disperse_mass(motion);
    for (i = 0; i < (int)m; i++) {
        const double frequency = matrices->frequency[i] * (1.0 + given->frequency_dispersion[i]);
        motion->stiffness[i] = frequency * frequency;
        motion->damping[i] = matrices->damping[i] * (1.0 + given->damping_dispersion[i]);
    }
    mark = memory->last;
    work = memory_doubles(memory, (6 + m) * (6 + m));
    if (memory->failed)
        return refuse(component, "there is not enough memory");
    if (split_body(motion, effective, work))
        return refuse_mass(component, given, matrices->modes);
    memory_rewind(memory, mark);
    if (find_free_modes(component, matrices->modes, effective, motion->stiffness, motion->damping, &motion->free) ||
        take_map(component, &motion->free, &motion->integral))
        return 1;
    mark = memory->last;
    on_modes = memory_doubles(memory, 2 * m * r);
    if (memory->failed)
        return refuse(component, "there is not enough memory");
    prepare_drive(motion, effective, on_modes, on_modes + m * r);
    memory_rewind(memory, mark);
    return prepare_outputs(component, motion);
}

int take_step(Component *component, const Motion *motion, PlantStep *step)
{
    Memory *memory = &component->memory;
    const int m = motion->matrices.modes, n = motion->matrices.wheels, r = motion->loads.count;

    step->length = 0.0;
    step->braked = -1;
    step->wheel = memory_take(memory, (size_t)n, sizeof(int));
    step->torque_of_speed = memory_doubles(memory, (size_t)n * (size_t)n);
    step->push_p = memory_doubles(memory, (size_t)m);
    step->push_q = memory_doubles(memory, (size_t)m);
    step->end_of_load = memory_doubles(memory, (size_t)motion->speeds * (size_t)r);
    if (memory->failed || panels_take(memory, 2 * m, r, &step->driven) ||
        panels_take(memory, motion->speeds, r, &step->middle_of_load))
        return refuse(component, "there is not enough memory");
    return take_map(component, &motion->free, &step->whole) || take_map(component, &motion->free, &step->half);
}

void at_step(Motion *motion, double length, PlantStep *step)
{
    const int m = motion->matrices.modes, r = motion->loads.count, speeds = motion->speeds;
    int i, j;

    step->length = length;
    step->braked = -1;
    free_transition(&motion->free, 0.5 * length, &step->half, &motion->integral);
    map_rows(&motion->free, &motion->integral, r, motion->drive, motion->driven);
    times_matrix(speeds, 2 * m, r, motion->speed_of_z, motion->driven, motion->of_load);
    panels_fill(motion->of_load, &step->middle_of_load);
    free_transition(&motion->free, length, &step->whole, &motion->integral);
    map_rows(&motion->free, &motion->integral, r, motion->drive, motion->driven);
    times_matrix(speeds, 2 * m, r, motion->speed_of_z, motion->driven, step->end_of_load);
    for (i = 0; i < motion->free.alone; i++) {
        const Map *held = &motion->integral;
        step->push_p[i] = held->pp[i] * motion->push_p[i] + held->pq[i] * motion->push_q[i];
        step->push_q[i] = held->qp[i] * motion->push_p[i] + held->qq[i] * motion->push_q[i];
        memset(motion->driven + (size_t)i * (size_t)r, 0, (size_t)r * sizeof(double));
        memset(motion->driven + (size_t)(motion->free.read + i) * (size_t)r, 0, (size_t)r * sizeof(double));
    }
    panels_fill(motion->driven, &step->driven);
    for (i = 0; i < 6; i++)
        for (j = 0; j < 6; j++)
            step->end_of_load[i * r + j] += length * motion->compliance[6 * i + j];
}
