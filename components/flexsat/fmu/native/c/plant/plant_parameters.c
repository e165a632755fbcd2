#include "plant_parameters.h"

#include <math.h>
#include <string.h>

#include "number_text.h"
#include "ports.h"
#include "random.h"
#include "turning_appendages.h"

enum { STREAM = 1, PHASES = 0, ATTITUDE = 1 }; /* the plant's random streams */
static const double TURN = 6.283185307179586;  /* 2 pi */

/* Copy the first rows and columns of a matrix of `width` columns. */
static const double *corner(Memory *memory, const double *a, int width, int rows, int columns)
{
    double *copy = memory_doubles(memory, (size_t)rows * (size_t)columns);
    int i;

    if (memory->failed)
        return NULL;
    for (i = 0; i < rows; i++)
        memcpy(copy + (size_t)i * (size_t)columns, a + (size_t)i * (size_t)width, (size_t)columns * sizeof(double));
    return copy;
}

int choose_matrices(Component *component, PlantMatrices *matrices)
{
    const PlantData *data = component->boolean[PORT_AS_PUBLISHED] ? &plant_as_published : &plant_corrected;
    const int all = data->frequency_rows, given = component->integer[PORT_MODES], m = given == 0 ? all : given;
    Memory *memory = &component->memory;

    if (component->boolean[PORT_AS_PUBLISHED] && !HAS_AS_PUBLISHED)
        return refuse(component, "as_published: this spacecraft has no published release; set it to false");
    if (m < 0 || m > all)
        return refuse(component, "modes must be from 1 to %d, or 0 for all of them, got %d", all, given);
    matrices->data = data;
    matrices->modes = m;
    matrices->wheels = data->wheel_axis_rows;
    matrices->mounts = data->wrench_influence_columns / 6;
    matrices->gyros = data->gyro_axis_rows;
    matrices->accelerometers = data->accelerometer_axis_rows;
    matrices->frequency = data->frequency;
    matrices->damping = data->damping;
    matrices->mass = corner(memory, data->mass_matrix, 6 + all, 6 + m, 6 + m);
    matrices->wrench = corner(memory, data->wrench_influence, 6 * matrices->mounts, 6 + m, 6 * matrices->mounts);
    matrices->gyro_slope = corner(memory, data->gyro_slope, all, matrices->gyros, m);
    matrices->deflection = corner(memory, data->accelerometer_deflection, all, matrices->accelerometers, m);
    matrices->wheel_axis = data->wheel_axis;
    matrices->lateral = data->lateral_influence + 3 * data->lateral_influence_columns;
    matrices->wheel_slope = data->wheel_slope;
    matrices->gyro_axis = data->gyro_axis;
    matrices->accelerometer_axis = data->accelerometer_axis;
    matrices->accelerometer_position = data->accelerometer_position;
    matrices->mount_turn = data->mount_turn;
    return memory->failed ? refuse(component, "there is not enough memory") : turn_appendages(component, matrices);
}

/* Refuse the initial motion of a mode that is not simulated. */
static int check_rest(Component *component, const char *name, const double *values, int modes, int size)
{
    int i;

    for (i = modes; i < size; i++)
        if (values[i] != 0.0)
            return refuse(component, "%s[%d] = %g: %d modes are simulated; set it to 0", name, i + 1, values[i], modes);
    return 0;
}

/* Refuse relative errors of which one is below -1, or is -1 where it must not be. */
static int check_dispersion(Component *component, const char *name, const double *values, int size, int may_be_least)
{
    double least = INFINITY;
    char text[NUMBER_SIZE];
    int i;

    for (i = 0; i < size; i++)
        if (!(values[i] >= least))
            least = values[i];
    if (size == 0 || least > -1.0 || (may_be_least && least >= -1.0))
        return 0;
    return refuse(component, "dispersion.%s: every relative error must be %s -1, got %s", name,
                  may_be_least ? ">=" : ">", number_text(least, text));
}

/* Refuse numbers of the motors that are negative, or a torque that falls beyond the speed limit. */
static int check_motors(Component *component, const PlantParameters *given, const double *factor, int wheels)
{
    const char *const names[] = {"torque_limit_factor", "speed_limit", "full_torque_speed", "torque_step"};
    const double *const values[] = {factor, given->speed_limit, given->full_torque_speed, given->torque_step};
    char text[NUMBER_SIZE];
    int i, j;

    for (j = 0; j < 4; j++)
        for (i = 0; i < wheels; i++)
            if (!(values[j][i] >= 0.0))
                return refuse(component, "wheel.%s[%d] must be >= 0, got %s", names[j], i + 1,
                              number_text(values[j][i], text));
    for (i = 0; i < wheels; i++)
        if (given->full_torque_speed[i] > given->speed_limit[i])
            return refuse(component, "wheel.full_torque_speed[%d] must be at most wheel.speed_limit[%d] = %g rad/s, got %s",
                          i + 1, i + 1, given->speed_limit[i], number_text(given->full_torque_speed[i], text));
    return 0;
}

static int check_parameters(Component *component, const PlantParameters *given, int modes)
{
    const double norm = sqrt(given->mrp[0] * given->mrp[0] + given->mrp[1] * given->mrp[1] +
                             given->mrp[2] * given->mrp[2]);
    char text[NUMBER_SIZE];

    if (!(norm <= 1.0))
        return refuse(component, "initial.mrp: norm must be <= 1 (short rotation), got %.6g", norm);
    if (!(given->torque_limit > 0.0))
        return refuse(component, "wheel.torque_limit must be > 0 N.m, got %s", number_text(given->torque_limit, text));
    return check_dispersion(component, "frequency", given->frequency_dispersion, modes, 0) ||
           check_dispersion(component, "inertia", given->inertia_dispersion, 3, 0) ||
           check_dispersion(component, "damping", given->damping_dispersion, modes, 1) ||
           check_dispersion(component, "participation", given->participation_dispersion, modes, 1);
}

int read_parameters(Component *component, const PlantMatrices *matrices, PlantParameters *parameters)
{
    const double *real = component->real;
    const int seed = component->integer[PORT_SEED], n = matrices->wheels, m = matrices->modes;
    const int random_phases = component->boolean[PORT_INITIAL_RANDOM_WHEEL_PHASES];
    Random random;
    int i;

    parameters->modal_displacement = real + PORT_INITIAL_MODAL_DISPLACEMENT;
    parameters->modal_velocity = real + PORT_INITIAL_MODAL_VELOCITY;
    if (check_rest(component, "initial.modal.displacement", parameters->modal_displacement, m,
                   PORT_INITIAL_MODAL_DISPLACEMENT_SIZE) ||
        check_rest(component, "initial.modal.velocity", parameters->modal_velocity, m, PORT_INITIAL_MODAL_VELOCITY_SIZE))
        return 1;
    if (seed < 0)
        return refuse(component, "seed must be >= 0, got %d", seed);
    parameters->rate = real + PORT_INITIAL_RATE;
    parameters->velocity = real + PORT_INITIAL_VELOCITY;
    parameters->frequency_dispersion = real + PORT_DISPERSION_FREQUENCY;
    parameters->damping_dispersion = real + PORT_DISPERSION_DAMPING;
    parameters->inertia_dispersion = real + PORT_DISPERSION_INERTIA;
    parameters->participation_dispersion = real + PORT_DISPERSION_PARTICIPATION;
    parameters->torque_limit = real[PORT_WHEEL_TORQUE_LIMIT];
    parameters->speed_limit = real + PORT_WHEEL_SPEED_LIMIT;
    parameters->full_torque_speed = real + PORT_WHEEL_FULL_TORQUE_SPEED;
    parameters->torque_step = real + PORT_WHEEL_TORQUE_STEP;
    parameters->torque_limits = memory_doubles(&component->memory, (size_t)n);
    parameters->gyroscopics = component->boolean[PORT_GYROSCOPICS];
    parameters->wheel_speed = memory_doubles(&component->memory, (size_t)n);
    parameters->wheel_angle = memory_doubles(&component->memory, (size_t)n);
    if (component->memory.failed)
        return refuse(component, "there is not enough memory");
    random_begin(&random, (uint64_t)seed, STREAM, PHASES);
    for (i = 0; i < n; i++) {
        const double drawn = random_uniform(&random, 0.0, TURN);
        parameters->wheel_speed[i] = matrices->data->nominal_speed[i] + real[PORT_INITIAL_WHEEL_SPEED_OFFSET + i];
        parameters->wheel_angle[i] = real[PORT_INITIAL_WHEEL_ANGLE + i] + (random_phases ? drawn : 0.0);
        parameters->torque_limits[i] = parameters->torque_limit * real[PORT_WHEEL_TORQUE_LIMIT_FACTOR + i];
    }
    random_begin(&random, (uint64_t)seed, STREAM, ATTITUDE);
    for (i = 0; i < 3; i++)
        parameters->mrp[i] =
            real[PORT_INITIAL_MRP + i] + 0.25 * (real[PORT_INITIAL_ATTITUDE_DEVIATION] * random_normal(&random));
    return check_parameters(component, parameters, m) ||
           check_motors(component, parameters, real + PORT_WHEEL_TORQUE_LIMIT_FACTOR, n);
}
