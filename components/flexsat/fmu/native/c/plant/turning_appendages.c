#include "turning_appendages.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"
#include "ports.h"
#include "vectors.h"

static const double RIGHT = 4.44e-16;      /* off a whole number, of a sine or cosine of a right angle */
static const double NO_COUPLING = 1e-11;   /* relative to the masses that are coupled */

/* Rotations of what turns from the angles of the file, and the interfaces; the last of each, that of -1, is for what
does not turn. */
typedef struct Turns {
    int parts;
    double *turn;     /* (t + 1, 3, 3) */
    double *point;    /* (t + 1, 3) [m] */
    double *moment;   /* (t, 3) [kg.m] the change of the first moments of mass */
    double centre[3]; /* m: of mass, from where it was */
} Turns;

const double *appendage_angles(const Component *component)
{
#ifdef PORT_APPENDAGE_ANGLE
    return component->real + PORT_APPENDAGE_ANGLE;
#else
    (void)component;
    return NULL;
#endif
}

static void rotation(const double *axis, double angle, double *matrix)
{
    const double sine = sin(angle), less = 1.0 - cos(angle);
    const double cross[9] = {0.0, -axis[2], axis[1], axis[2], 0.0, -axis[0], -axis[1], axis[0], 0.0};
    int i, j;

    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) {
            const double one = i == j ? 1.0 : 0.0;
            const double value = one + sine * cross[3 * i + j] + less * (axis[i] * axis[j] - one);
            const double near = floor(value + 0.5);
            matrix[3 * i + j] = fabs(value - near) < RIGHT ? near : value;
        }
}

static const double *turn_of(const Turns *turns, int part)
{
    return turns->turn + 9 * (part < 0 ? turns->parts : part);
}

static const double *point_of(const Turns *turns, int part)
{
    return turns->point + 3 * (part < 0 ? turns->parts : part);
}

/* Return vectors (count, 3), each turned with its part; or the positions that they are, from the new centre. */
static double *turned(Memory *memory, const Turns *turns, int count, const int *part, const double *vectors, int place)
{
    double *result = memory_doubles(memory, 3 * (size_t)count);
    int i, k;

    for (k = 0; k < count && !memory->failed; k++) {
        const double *point = point_of(turns, part[k]);
        double vector[3];
        for (i = 0; i < 3; i++)
            vector[i] = vectors[3 * k + i] - (place ? point[i] : 0.0);
        times3(turn_of(turns, part[k]), vector, result + 3 * k);
        for (i = 0; i < 3 && place; i++)
            result[3 * k + i] += point[i] - turns->centre[i];
    }
    return result;
}

/* The change of an appendage's inertia about the old centre of mass. */
static void add_inertia(const PlantData *data, const Turns *turns, int part, double inertia[9])
{
    const double *turn = turn_of(turns, part), *point = point_of(turns, part), *moment = turns->moment + 3 * part;
    const double *own = data->turn_inertia + 9 * part;
    double half[9], back[9], full[9];
    int i, j;

    times_matrix(3, 3, 3, turn, own, half);
    transpose(3, 3, turn, back);
    times_matrix(3, 3, 3, half, back, full);
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) {
            inertia[3 * i + j] += full[3 * i + j] - own[3 * i + j] - point[i] * moment[j] - point[j] * moment[i];
            if (i == j)
                inertia[3 * i + j] += 2.0 * dot3(point, moment);
        }
}

static void turn_inertia(const PlantData *data, const Turns *turns, int size, double *mass)
{
    const double *c = turns->centre;
    double change[9] = {0.0};
    int part, i, j;

    for (part = 0; part < turns->parts; part++)
        add_inertia(data, turns, part, change);
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++)
            mass[(3 + i) * size + 3 + j] +=
                change[3 * i + j] - mass[0] * ((i == j ? dot3(c, c) : 0.0) - c[i] * c[j]);
}

/* The mass matrix about the new centre of mass, from that about the old one. */
static void turn_mass(const PlantData *data, const Turns *turns, int m, double *mass)
{
    const int size = 6 + m;
    double diagonal_i, diagonal_j;
    int i, j;

    turn_inertia(data, turns, size, mass);
    for (j = 0; j < m; j++) {
        const double *turn = turn_of(turns, data->mode_part[j]), *point = point_of(turns, data->mode_part[j]);
        double momentum[3], about[3], arm[3], moved[3], own[3], change[3];
        for (i = 0; i < 3; i++) {
            momentum[i] = mass[i * size + 6 + j];
            about[i] = mass[(3 + i) * size + 6 + j];
            arm[i] = point[i] - turns->centre[i];
        }
        cross3(point, momentum, change);
        for (i = 0; i < 3; i++)
            about[i] -= change[i];
        times3(turn, momentum, moved);
        times3(turn, about, own);
        cross3(arm, moved, change);
        for (i = 0; i < 3; i++) {
            mass[i * size + 6 + j] = mass[(6 + j) * size + i] = moved[i];
            mass[(3 + i) * size + 6 + j] = mass[(6 + j) * size + 3 + i] = own[i] + change[i];
        }
    }
    for (i = 0; i < size; i++) /* the diagonal stays */
        for (j = 0; j < size; j++) {
            diagonal_i = mass[i * size + i], diagonal_j = mass[j * size + j];
            if (!(fabs(mass[i * size + j]) > NO_COUPLING * sqrt(diagonal_i * diagonal_j)))
                mass[i * size + j] = 0.0;
        }
}

/* Generalised forces of unit wrenches on the mounts, in body axes. */
static void turn_wrenches(const PlantData *data, const Turns *turns, int m, int s, const double *position,
                          double *wrench)
{
    const int width = 6 * s;
    int mount, kind, i, j;

    for (mount = 0; mount < s; mount++) {
        const double *turn = turn_of(turns, data->mount_part[mount]);
        for (i = 0; i < 3; i++) {
            const double along[3] = {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
            double torque[3];
            cross3(position + 3 * mount, along, torque);
            for (j = 0; j < 3; j++)
                wrench[(3 + j) * width + i * s + mount] = torque[j];
        }
        for (j = 0; j < m; j++)
            for (kind = 0; kind < 2; kind++) {
                double *row = wrench + (size_t)(6 + j) * (size_t)width + (size_t)(3 * kind * s + mount);
                const double before[3] = {row[0], row[s], row[2 * s]};
                for (i = 0; i < 3; i++)
                    row[i * s] = dot3(turn + 3 * i, before);
            }
    }
}

/* What points with the wheels and their mounts. */
static int turn_wheels(Component *component, const Turns *turns, PlantMatrices *matrices)
{
    const PlantData *data = matrices->data;
    const int n = matrices->wheels, s = matrices->mounts, all = data->frequency_rows;
    const size_t slopes = 3 * (size_t)n * (size_t)all;
    Memory *memory = &component->memory;
    double *axis = memory_doubles(memory, 3 * (size_t)n), *lateral = memory_doubles(memory, 6 * (size_t)n);
    double *slope = memory_doubles(memory, slopes), *mount_turn = memory_doubles(memory, 9 * (size_t)s);
    int k, i, j;

    if (memory->failed)
        return 1;
    for (k = 0; k < n; k++) {
        const double *turn = turn_of(turns, data->mount_part[data->mount_of_wheel[k]]);
        times3(turn, data->wheel_axis + 3 * k, axis + 3 * k);
        times_matrix(3, 3, all, turn, data->wheel_slope + (size_t)(3 * k) * (size_t)all,
                     slope + (size_t)(3 * k) * (size_t)all);
        for (i = 0; i < 3; i++)
            for (j = 0; j < 3; j++) {
                lateral[i * 2 * n + k] += turn[3 * i + j] * matrices->lateral[j * 2 * n + k];
                lateral[i * 2 * n + n + k] += turn[3 * i + j] * matrices->lateral[j * 2 * n + n + k];
            }
    }
    for (k = 0; k < s; k++)
        times_matrix(3, 3, 3, turn_of(turns, data->mount_part[k]), data->mount_turn + 9 * k, mount_turn + 9 * k);
    matrices->wheel_axis = axis, matrices->lateral = lateral, matrices->wheel_slope = slope;
    matrices->mount_turn = mount_turn;
    return 0;
}

static int take_turns(Memory *memory, const PlantData *data, const double *angle, Turns *turns)
{
    const int t = data->turn_axis_rows;
    int part, i;

    turns->parts = t;
    turns->turn = memory_doubles(memory, 9 * (size_t)(t + 1));
    turns->point = memory_doubles(memory, 3 * (size_t)(t + 1));
    turns->moment = memory_doubles(memory, 3 * (size_t)t);
    if (memory->failed)
        return 1;
    identity(3, turns->turn + 9 * t);
    memcpy(turns->point, data->turn_point, 3 * (size_t)t * sizeof(double));
    memset(turns->centre, 0, sizeof turns->centre);
    for (part = 0; part < t; part++) {
        rotation(data->turn_axis + 3 * part, angle[part] - data->turn_angle[part], turns->turn + 9 * part);
        times3(turns->turn + 9 * part, data->turn_moment + 3 * part, turns->moment + 3 * part);
        for (i = 0; i < 3; i++) {
            turns->moment[3 * part + i] -= data->turn_moment[3 * part + i];
            turns->centre[i] += turns->moment[3 * part + i];
        }
    }
    for (i = 0; i < 3; i++)
        turns->centre[i] /= data->mass_matrix[0];
    return 0;
}

static double *copied(Memory *memory, const double *values, size_t count)
{
    double *copy = memory_doubles(memory, count);

    if (!memory->failed)
        memcpy(copy, values, count * sizeof(double));
    return copy;
}

int turn_appendages(Component *component, PlantMatrices *matrices)
{
    const PlantData *data = matrices->data;
    const double *angle = appendage_angles(component);
    const int m = matrices->modes, s = matrices->mounts, t = data->turn_axis_rows;
    const size_t size = 6 + (size_t)m, width = 6 * (size_t)s;
    Memory *memory = &component->memory;
    double *mass, *wrench, *position;
    Turns turns;
    int part = 0;

    while (part < t && angle[part] == data->turn_angle[part])
        part++;
    if (part == t)
        return 0;
    mass = copied(memory, matrices->mass, size * size);
    wrench = copied(memory, matrices->wrench, size * width);
    if (memory->failed || take_turns(memory, data, angle, &turns) || turn_wheels(component, &turns, matrices))
        return refuse(component, "there is not enough memory");
    position = turned(memory, &turns, s, data->mount_part, data->mount_position, 1);
    matrices->gyro_axis = turned(memory, &turns, matrices->gyros, data->gyro_part, data->gyro_axis, 0);
    matrices->accelerometer_axis =
        turned(memory, &turns, matrices->accelerometers, data->accelerometer_part, data->accelerometer_axis, 0);
    matrices->accelerometer_position =
        turned(memory, &turns, matrices->accelerometers, data->accelerometer_part, data->accelerometer_position, 1);
    if (memory->failed)
        return refuse(component, "there is not enough memory");
    turn_mass(data, &turns, m, mass);
    turn_wrenches(data, &turns, m, s, position, wrench);
    matrices->mass = mass, matrices->wrench = wrench;
    return 0;
}
