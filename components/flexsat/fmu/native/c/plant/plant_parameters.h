/* The matrices of the spacecraft that a run simulates, and the parameters of the run: the twin of
runtime/plant_parameters.py and of the parameters in ports/plant.py. */
#ifndef FLEXSAT_PLANT_PARAMETERS_H
#define FLEXSAT_PLANT_PARAMETERS_H

#include "component.h"
#include "data.h"

/* As PlantMatrices in Python; velocities are ordered (v, w, eta'). Arrays are row after row. */
typedef struct PlantMatrices {
    int modes, wheels, mounts, gyros, accelerometers; /* m, n, s, g, k */
    const double *mass;                               /* (6 + m, 6 + m) */
    const double *frequency, *damping;                /* (m) [rad/s], [1/s] */
    const double *wrench;                             /* (6 + m, 6 s) */
    const double *gyro_slope;                         /* (g, m) */
    const double *deflection;                         /* (k, m) of the accelerometers */
    const double *wheel_axis, *lateral;               /* (n, 3); (3, 2 n): their axes a, then b */
    const double *wheel_slope;                        /* (n, 3, all modes) */
    const double *gyro_axis;                          /* (g, 3) */
    const double *accelerometer_axis, *accelerometer_position; /* (k, 3); (k, 3) [m] */
    const double *mount_turn;                         /* (s, 3, 3): body axes from those of the mount's jitter */
    const PlantData *data;                            /* the others, with all modes where there are modes */
} PlantMatrices;

typedef struct PlantParameters {
    double mrp[3];
    double *wheel_speed, *wheel_angle;                                             /* (n) [rad/s], [rad] */
    const double *rate, *velocity;                                                 /* (3) [rad/s], [m/s] */
    const double *modal_displacement, *modal_velocity;                             /* (m) */
    const double *frequency_dispersion, *damping_dispersion, *inertia_dispersion; /* (m), (m), (3), relative */
    const double *participation_dispersion;                                        /* (m) relative */
    double torque_limit;                                                           /* N.m, times the factor of each */
    double *torque_limits;                                                         /* (n) [N.m] */
    const double *speed_limit, *full_torque_speed, *torque_step; /* (n) [rad/s], [rad/s], [N.m]; 0: none */
    int gyroscopics;
} PlantParameters;

/* Choose the variant, the number of modes and the angles of appendages by the component's parameters. */
int choose_matrices(Component *component, PlantMatrices *matrices);

/* Read the parameters, and draw from the seed what is random at the start. */
int read_parameters(Component *component, const PlantMatrices *matrices, PlantParameters *parameters);

#endif
