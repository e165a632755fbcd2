#include "loads.h"

#include <string.h>

#include "linear_algebra.h"

double lateral_axis(const PlantMatrices *matrices, int which, int wheel, int axis)
{
    const int width = 2 * matrices->wheels;

    return matrices->lateral[axis * width + which * matrices->wheels + wheel];
}

/* The wrenches on the mounts, (6 s, held), of what is held. */
static void wrenches(const PlantMatrices *matrices, int held, double *wrench)
{
    const int n = matrices->wheels, s = matrices->mounts, about_a = n + 6 * s + 6;
    const double *axes = matrices->wheel_axis;
    int wheel, axis, i, j, mount;

    for (wheel = 0; wheel < n; wheel++)
        for (axis = 0; axis < 3; axis++) {
            double *row = wrench + (size_t)(3 * s + axis * s + matrices->data->mount_of_wheel[wheel]) * (size_t)held;
            row[wheel] = -axes[3 * wheel + axis];
            row[about_a + wheel] = -lateral_axis(matrices, 0, wheel, axis);
            row[about_a + n + wheel] = -lateral_axis(matrices, 1, wheel, axis);
        }
    for (mount = 0; mount < s; mount++) /* jitter in axes that turn with the mount: its forces, then its torques */
        for (i = 0; i < 6; i++)
            for (j = i / 3 * 3; j < i / 3 * 3 + 3; j++)
                wrench[(size_t)(i * s + mount) * (size_t)held + (size_t)(n + j * s + mount)] =
                    matrices->mount_turn[9 * mount + 3 * (i % 3) + j % 3];
}

/* Whether a component of the wrenches moves a mode; of a mount that turns, whether any of the three does. */
static int moves(const PlantMatrices *matrices, int column)
{
    const int s = matrices->mounts, width = 6 * s, turns = matrices->data->mount_part[column % s] >= 0;
    const int first = turns ? column / (3 * s) * 3 * s + column % s : column, count = turns ? 3 : 1;
    int i, j;

    for (i = 0; i < count; i++)
        for (j = 0; j < matrices->modes; j++)
            if (matrices->wrench[(size_t)(6 + j) * (size_t)width + (size_t)(first + i * s)] != 0.0)
                return 1;
    return 0;
}

static void fill_forces(const PlantMatrices *matrices, const double *wrench, Loads *loads)
{
    const size_t held = (size_t)loads->held, r = (size_t)loads->count, width = 6 * (size_t)matrices->mounts;
    const size_t external = (size_t)matrices->wheels + width;
    const double *mass = matrices->mass;
    const int m = matrices->modes;
    size_t load = 6, i, column;
    int j;

    times_matrix(6, (int)width, (int)held, matrices->wrench, wrench, loads->of_held);
    for (i = 0; i < 6; i++) {
        loads->of_held[i * held + external + i] = 1.0;
        loads->of_held[i * held + held - 6 + i] = -1.0;
        loads->force[i * r + i] = 1.0;
    }
    for (column = 0; column < width; column++)
        if (moves(matrices, (int)column)) {
            memcpy(loads->of_held + load * held, wrench + column * held, held * sizeof(double));
            for (j = 0; j < m; j++)
                loads->force[(size_t)(6 + j) * r + load] = matrices->wrench[(size_t)(6 + j) * width + column];
            load++;
        }
    for (i = 0; i < 3; i++, load++) {
        loads->of_held[load * held + held - 6 + i] = 1.0;
        for (j = 0; j < m; j++) /* the sign is not P's: with it uniform motion of the whole changes nothing */
            loads->force[(size_t)(6 + j) * r + load] = -mass[i * (size_t)(6 + m) + (size_t)(6 + j)] / mass[0];
    }
}

/* Return the place of a row of slopes, (m) with a distance between its elements, among those that differ; add it to
them if it is new. */
static int distinct_row(int m, const double *row, size_t distance, Loads *loads)
{
    int any = 0, place, j;

    for (j = 0; j < m; j++)
        any |= row[(size_t)j * distance] != 0.0;
    if (!any)
        return -1;
    for (place = 0; place < loads->turns; place++) {
        const double *known = loads->slopes + (size_t)place * (size_t)m;
        for (j = 0; j < m && known[j] == row[(size_t)j * distance]; j++)
            ;
        if (j == m)
            return place;
    }
    for (j = 0; j < m; j++)
        loads->slopes[(size_t)place * (size_t)m + (size_t)j] = row[(size_t)j * distance];
    return loads->turns++;
}

int prepare_loads(Component *component, const PlantMatrices *matrices, Loads *loads)
{
    const int n = matrices->wheels, s = matrices->mounts, m = matrices->modes, g = matrices->gyros;
    const size_t width = 6 * (size_t)s;
    Memory *memory = &component->memory;
    MemoryBlock *mark;
    double *wrench;
    int i;

    loads->inputs = n + 6 * s + 6;
    loads->held = loads->inputs + 2 * n + 6;
    loads->count = 6 + 3;
    loads->turns = 0;
    for (i = 0; i < 6 * s; i++)
        loads->count += moves(matrices, i);
    loads->of_held = memory_doubles(memory, (size_t)loads->count * (size_t)loads->held);
    loads->force = memory_doubles(memory, (size_t)(6 + m) * (size_t)loads->count);
    loads->slopes = memory_doubles(memory, (size_t)(3 * s + g) * (size_t)m);
    loads->mount_slope = memory_take(memory, 3 * (size_t)s, sizeof(int));
    loads->gyro_slope = memory_take(memory, (size_t)g, sizeof(int));
    mark = memory->last;
    wrench = memory_doubles(memory, width * (size_t)loads->held);
    if (memory->failed)
        return refuse(component, "there is not enough memory");
    wrenches(matrices, loads->held, wrench);
    fill_forces(matrices, wrench, loads);
    memory_rewind(memory, mark);
    for (i = 0; i < 3 * s; i++)
        loads->mount_slope[i] = distinct_row(m, matrices->wrench + 6 * width + (size_t)(3 * s + i), width, loads);
    for (i = 0; i < g; i++)
        loads->gyro_slope[i] = distinct_row(m, matrices->gyro_slope + (size_t)i * (size_t)m, 1, loads);
    return 0;
}
