#include "plant_outputs.h"

#include <string.h>

#include "linear_algebra.h"

/* Map z to the speeds (6 + u, 2 m), and to the turn of the body due to eta, (3, 2 m): the integral of its rate. */
static void speeds_of_z(const Motion *motion, double *of_speed, double *turn)
{
    const int m = motion->matrices.modes;
    const size_t carried = 6 * (size_t)m;
    size_t e;

    for (e = 0; e < carried; e++)
        of_speed[e] = -motion->carried[e];
    memcpy(of_speed + carried, motion->loads.slopes, (size_t)motion->loads.turns * (size_t)m * sizeof(double));
    from_coordinates(&motion->free, motion->free.velocity, motion->speeds, of_speed, motion->speed_of_z);
    from_coordinates(&motion->free, motion->free.displacement, 3, of_speed + 3 * m, turn);
}

/* Fill of_force (k, 6 + m): accelerations without products from generalised forces; `work` holds (6 + m) (6 + m + k)
doubles. */
static void accelerations_of_force(const Motion *motion, double *of_force, double *work)
{
    const PlantMatrices *matrices = &motion->matrices;
    const int m = matrices->modes, k = matrices->accelerometers, size = 6 + m;
    double *mass = work, *columns = mass + (size_t)size * (size_t)size; /* (6 + m, k) */
    int i, j;

    for (i = 0; i < k; i++) {
        const double *axis = matrices->accelerometer_axis + 3 * i;
        const double *position = matrices->accelerometer_position + 3 * i;
        columns[0 * k + i] = axis[0], columns[1 * k + i] = axis[1], columns[2 * k + i] = axis[2];
        columns[3 * k + i] = position[1] * axis[2] - position[2] * axis[1];
        columns[4 * k + i] = position[2] * axis[0] - position[0] * axis[2];
        columns[5 * k + i] = position[0] * axis[1] - position[1] * axis[0];
        for (j = 0; j < m; j++)
            columns[(6 + j) * k + i] = matrices->deflection[i * m + j];
    }
    memcpy(mass, motion->mass, (size_t)size * (size_t)size * sizeof(double));
    solve(size, k, mass, columns); /* which is regular: it is positive definite */
    transpose(size, k, columns, of_force);
}

/* Accelerations by stiffness and damping, (k, 2 m). What a part of one mode restores is one number of both of its
coordinates, folded into the first. */
static void restoring(Motion *motion, const double *of_force, double *rows, double *by_eta, double *by_speed,
                      double *part)
{
    const FreeModes *free = &motion->free;
    const int m = motion->matrices.modes, k = motion->matrices.accelerometers;
    size_t e;
    int i, j;

    for (i = 0; i < k; i++)
        for (j = 0; j < m; j++) {
            by_eta[i * m + j] = -of_force[i * (6 + m) + 6 + j] * motion->stiffness[j];
            by_speed[i * m + j] = -of_force[i * (6 + m) + 6 + j] * motion->damping[j];
        }
    from_coordinates(&motion->free, motion->free.displacement, k, by_eta, rows);
    from_coordinates(&motion->free, motion->free.velocity, k, by_speed, part);
    for (e = 0; e < 2 * (size_t)k * (size_t)m; e++)
        rows[e] += part[e];
    for (j = 0; j < free->alone; j++) {
        const double *displacement = free->displacement + free->place[j], *velocity = free->velocity + free->place[j];
        const int mode = free->mode[j];
        motion->fold_p[j] = motion->stiffness[mode] * displacement[0] + motion->damping[mode] * velocity[0];
        motion->fold_q[j] = motion->stiffness[mode] * displacement[1] + motion->damping[mode] * velocity[1];
        for (i = 0; i < k; i++) {
            rows[i * 2 * m + j] = -of_force[i * (6 + m) + 6 + mode];
            rows[i * 2 * m + free->q[j]] = 0.0;
        }
    }
}

/* The rows of the slopes at a wheel's mount about x, y, z; -1 where there is none. */
static void wheel_slopes(const Motion *motion, int wheel, int slope[3])
{
    const int s = motion->matrices.mounts, mount = motion->matrices.data->mount_of_wheel[wheel];
    int axis;

    for (axis = 0; axis < 3; axis++)
        slope[axis] = motion->loads.mount_slope[axis * s + mount];
}

/* Add to a row of the speeds what a vector at a mount or gyro picks: of the body's rate, and of the slope rates. */
static void pick(const int slope[3], const double *vector, double factor, int first, double *row)
{
    int axis;

    for (axis = 0; axis < 3; axis++) {
        row[first + axis] += factor * vector[axis];
        if (slope[axis] >= 0)
            row[first + 3 + slope[axis]] += factor * vector[axis];
    }
}

/* Map rate and slope rates to the factors of the gyroscopic torques, (2 n, 3 + u). */
static void gyroscopic(const Motion *motion, double *rows)
{
    const PlantMatrices *matrices = &motion->matrices;
    const int n = matrices->wheels, width = 3 + motion->loads.turns;
    int wheel, axis, slope[3];

    for (wheel = 0; wheel < n && motion->parameters.gyroscopics; wheel++) {
        const double sense = matrices->data->wheel_sense[wheel];
        double a[3], b[3];
        for (axis = 0; axis < 3; axis++) {
            a[axis] = lateral_axis(matrices, 0, wheel, axis);
            b[axis] = lateral_axis(matrices, 1, wheel, axis);
        }
        wheel_slopes(motion, wheel, slope);
        pick(slope, b, sense, 0, rows + wheel * width);         /* w_b times h: torque about a */
        pick(slope, a, -sense, 0, rows + (n + wheel) * width); /* -w_a times h: torque about b */
    }
}

/* P, equation for y_amu: w x v, and the centripetal term a . (w (w . r) - r w^2). Its Coriolis term vanishes: what
moves with the structure senses along z, and so it moves. */
static void accelerometer_products(const double *axis, const double *position, double *row)
{
    static const int first[3] = {0, 0, 1}, second[3] = {1, 2, 2};
    const double along = axis[0] * position[0] + axis[1] * position[1] + axis[2] * position[2];
    int i;

    for (i = 0; i < 3; i++) {
        row[i] = axis[i];
        row[3 + i] = axis[i] * position[i] - along;
        row[6 + i] = axis[first[i]] * position[second[i]] + axis[second[i]] * position[first[i]];
    }
}

/* The output map, and its part for the speeds of the mounts about the wheels' axes, (n, 6 + u). */
static void output_rows(const Motion *motion, int width, double *rows, double *mount_speed)
{
    const PlantMatrices *matrices = &motion->matrices;
    const int n = matrices->wheels, g = matrices->gyros, k = matrices->accelerometers, speeds = motion->speeds;
    int i, slope[3];

    for (i = 0; i < 3; i++) {
        rows[i * width + 3 + i] = 1.0;
        rows[(3 + i) * width + i] = 1.0;
    }
    rows += 6 * width;
    for (i = 0; i < n; i++, rows += width) {
        wheel_slopes(motion, i, slope);
        pick(slope, matrices->wheel_axis + 3 * i, -1.0, 3, mount_speed + i * speeds);
        memcpy(rows, mount_speed + i * speeds, (size_t)speeds * sizeof(double));
        rows[speeds + k + i] = 1.0 / matrices->data->wheel_inertia[i];
    }
    for (i = 0; i < g; i++, rows += width) {
        memcpy(rows + 3, matrices->gyro_axis + 3 * i, 3 * sizeof(double));
        if (motion->loads.gyro_slope[i] >= 0)
            rows[6 + motion->loads.gyro_slope[i]] = 1.0;
    }
    for (i = 0; i < k; i++, rows += width) {
        rows[speeds + i] = 1.0;
        accelerometer_products(matrices->accelerometer_axis + 3 * i, matrices->accelerometer_position + 3 * i,
                               rows + speeds + k + n);
    }
}

/* Arrange what is sparse; `rows` and `mount_speed` are scratch, filled with zeros. */
static int sparse_maps(Component *component, Motion *motion, double *rows, double *mount_speed)
{
    Memory *memory = &component->memory;
    const Loads *loads = &motion->loads;
    const int n = motion->matrices.wheels, k = motion->matrices.accelerometers, r = loads->count;
    const int outputs = 6 + n + motion->matrices.gyros + k, width = motion->speeds + k + n + PRODUCTS;
    const int internal = loads->held - loads->inputs, start[2] = {0, loads->inputs};
    const int count[2] = {loads->inputs, internal};
    int which, i;

    output_rows(motion, width, rows, mount_speed);
    if (sparse_of(memory, outputs, width, rows, &motion->output) ||
        sparse_of(memory, n, motion->speeds, mount_speed, &motion->mount_speed))
        return 1;
    memset(rows, 0, (size_t)outputs * (size_t)width * sizeof(double));
    gyroscopic(motion, rows);
    if (sparse_of(memory, 2 * n, 3 + loads->turns, rows, &motion->gyroscopic))
        return 1;
    for (which = 0; which < 2; which++) {
        for (i = 0; i < r; i++)
            memcpy(rows + i * count[which], loads->of_held + i * loads->held + start[which],
                   (size_t)count[which] * sizeof(double));
        if (sparse_of(memory, r, count[which], rows, which ? &motion->load_of_internal : &motion->load_of_input))
            return 1;
    }
    return 0;
}

int prepare_outputs(Component *component, Motion *motion)
{
    Memory *memory = &component->memory;
    const size_t m = (size_t)motion->matrices.modes, k = (size_t)motion->matrices.accelerometers;
    const size_t n = (size_t)motion->matrices.wheels, g = (size_t)motion->matrices.gyros, size = 6 + m;
    const size_t r = (size_t)motion->loads.count, held = (size_t)motion->loads.held, speeds = (size_t)motion->speeds;
    const size_t output = (6 + n + g + k) * (speeds + k + n + PRODUCTS) + 2 * n * speeds + r * held;
    double *rows, *turn, *of_force, *work;

    motion->speed_of_z = memory_doubles(memory, speeds * 2 * m);
    motion->fold_p = memory_doubles(memory, m);
    motion->fold_q = memory_doubles(memory, m);
    turn = memory_doubles(memory, 3 * 2 * m);
    if (memory->failed || panels_take(memory, (int)speeds, 2 * (int)m, &motion->speed) ||
        panels_take(memory, (int)k, 2 * (int)m, &motion->restoring) ||
        panels_take(memory, (int)k, (int)r, &motion->acceleration))
        return refuse(component, "there is not enough memory");
    {
        MemoryBlock *mark = memory->last;
        rows = memory_doubles(memory, k * 2 * m);
        of_force = memory_doubles(memory, k * size);
        work = memory_doubles(memory, size * (size + k) + speeds * m + 4 * k * m + k * r);
        if (memory->failed)
            return refuse(component, "there is not enough memory");
        speeds_of_z(motion, work, turn);
        panels_fill(motion->speed_of_z, &motion->speed);
        accelerations_of_force(motion, of_force, work);
        restoring(motion, of_force, rows, work, work + k * m, work + 2 * k * m);
        panels_fill(rows, &motion->restoring);
        times_matrix((int)k, (int)size, (int)r, of_force, motion->loads.force, work);
        panels_fill(work, &motion->acceleration);
        memory_rewind(memory, mark);
    }
    /* this scratch stays: what is sparse is taken behind it */
    work = memory_doubles(memory, output + n * speeds);
    if (memory->failed || sparse_of(memory, 3, 2 * (int)m, turn, &motion->turn) ||
        sparse_maps(component, motion, work, work + output))
        return refuse(component, "there is not enough memory");
    return 0;
}
