/* The few numbers through which everything that acts on the structure acts on it: the twin of runtime/loads.py.

What is held over a step, in this order: wheel torques (n), jitter wrenches on the mounts (6 s), external force and
torque (6), gyroscopic torques about the wheels' axes a and b (2 n), momentum terms (6). */
#ifndef FLEXSAT_LOADS_H
#define FLEXSAT_LOADS_H

#include "plant_parameters.h"

typedef struct Loads {
    int count;        /* r: resultant (6), what moves the modes, w x p (3) */
    int inputs, held; /* columns of of_held, those of inputs first */
    int turns;        /* u: rates of rotation of mounts and gyros that differ, and are not 0 */
    double *of_held;  /* (r, held) */
    double *force;    /* (6 + m, r) */
    double *slopes;   /* (u, m) per unit modal velocity */
    int *mount_slope; /* (3 s) row of `slopes` for each mount about x, y, z; -1: it does not turn */
    int *gyro_slope;  /* (g) */
} Loads;

/* Component `axis` of a wheel's lateral axis, 0 for a and 1 for b. */
double lateral_axis(const PlantMatrices *matrices, int which, int wheel, int axis);

int prepare_loads(Component *component, const PlantMatrices *matrices, Loads *loads);

#endif
