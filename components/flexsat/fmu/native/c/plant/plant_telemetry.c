#include "plant_telemetry.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"
#include "ports.h"
#include "rotations.h"

void add_wheels(const Plant *plant, const double *eta, double momentum[3])
{
    const Motion *motion = &plant->motion;
    const int s = motion->matrices.mounts;
    double *slopes = plant->work.speeds; /* (u), of all mounts */
    int wheel, i;

    times_vector(motion->loads.turns, motion->matrices.modes, motion->loads.slopes, eta, slopes);
    for (wheel = 0; wheel < motion->matrices.wheels; wheel++) {
        const double *axis = motion->matrices.wheel_axis + 3 * wheel, axial = plant->state.axial[wheel];
        double slope[3] = {0.0, 0.0, 0.0};
        for (i = 0; i < 3; i++) {
            const int row = motion->loads.mount_slope[i * s + motion->matrices.data->mount_of_wheel[wheel]];
            if (row >= 0)
                slope[i] = slopes[row];
        }
        momentum[0] += axial * (axis[0] + slope[1] * axis[2] - slope[2] * axis[1]);
        momentum[1] += axial * (axis[1] + slope[2] * axis[0] - slope[0] * axis[2]);
        momentum[2] += axial * (axis[2] + slope[0] * axis[1] - slope[1] * axis[0]);
    }
}

/* Twice the energy of body and structure, and of the rotors. */
static double twice_energy(const Plant *plant, const double *eta, const double *speed, const double *body)
{
    const Motion *motion = &plant->motion;
    const int m = motion->matrices.modes, size = 6 + m;
    const double *inertia = motion->matrices.data->wheel_inertia;
    double energy = 0.0, rotors = 0.0;
    int i, j;

    for (i = 0; i < 6; i++)
        energy += body[i] * plant->state.momentum[i];
    for (i = 0; i < m; i++) {
        double momentum = speed[i];
        for (j = 0; j < 6; j++)
            momentum += motion->mass[(6 + i) * size + j] * body[j];
        energy += speed[i] * momentum + eta[i] * motion->stiffness[i] * eta[i];
    }
    for (i = 0; i < motion->matrices.wheels; i++)
        rotors += plant->state.axial[i] * plant->state.axial[i] * (inertia[0] / inertia[i]);
    return energy + rotors / inertia[0];
}

void plant_telemetry(Component *component, Plant *plant)
{
    const Motion *motion = &plant->motion;
    const int m = motion->matrices.modes;
    double *eta = plant->work.structure, *speed = eta + m, *real = component->real;
    double body[6], momentum[3], direction[9], square = 0.0;
    int i, j;

    structure_of(&motion->free, motion->free.displacement, plant->state.z, eta);
    structure_of(&motion->free, motion->free.velocity, plant->state.z, speed);
    times_vector(6, 6, motion->compliance, plant->state.momentum, body);
    for (i = 0; i < 6; i++)
        for (j = 0; j < m; j++)
            body[i] -= motion->carried[i * m + j] * speed[j];
    memcpy(momentum, plant->state.momentum + 3, sizeof momentum);
    add_wheels(plant, eta, momentum);
    matrix_from_mrp(plant->state.mrp, direction);
    for (i = 0; i < 3; i++) { /* body from inertial, transposed */
        real[PORT_ANGULAR_MOMENTUM + i] = 0.0;
        for (j = 0; j < 3; j++)
            real[PORT_ANGULAR_MOMENTUM + i] += direction[3 * j + i] * momentum[j];
    }
    real[PORT_ENERGY] = 0.5 * twice_energy(plant, eta, speed, body);
    for (i = 0; i < PORT_MODAL_DISPLACEMENT_SIZE; i++) { /* 0 for the modes that are not simulated */
        real[PORT_MODAL_DISPLACEMENT + i] = i < m ? eta[i] : 0.0;
        real[PORT_MODAL_VELOCITY + i] = i < m ? speed[i] : 0.0;
        square += i < m ? eta[i] * eta[i] : 0.0;
    }
    real[PORT_RMS_DEFORMATION] = sqrt(square) / sqrt(motion->mass[0]);
}
