/* The plant prepared for one run, and for steps of one length: the twin of runtime/prepared_plant.py.

Where Python has one matrix for a vector of z, momenta and loads, its parts stand by themselves here: what is linear in
z passes through few numbers, at the middle of a step and at its end through the same. */
#ifndef FLEXSAT_PREPARED_PLANT_H
#define FLEXSAT_PREPARED_PLANT_H

#include "loads.h"
#include "mode_maps.h"
#include "panels.h"

enum { PRODUCTS = 9 }; /* products of velocities in the accelerations: w x v, and w_i w_j as xx yy zz xy xz yz */

/* The spacecraft of one run, for steps of any length. */
typedef struct Motion {
    PlantMatrices matrices;
    PlantParameters parameters;
    Loads loads;
    FreeModes free;
    int speeds;          /* 6 + u: velocity, rate, slope rates */
    double *mass;        /* (6 + m, 6 + m) with its dispersion */
    double *stiffness;   /* (m) [1/s2] */
    double *damping;     /* (m) [1/s] */
    double *compliance;  /* (6, 6): inverse of the rigid mass */
    double *carried;     /* (6, m): (v, w) = compliance momentum - carried eta' */
    double *drive;       /* (2 m, r): z' = A z + drive loads */
    double *speed_of_z;  /* (6 + u, 2 m): without what is due to momenta */
    Panels speed;        /* the same, to multiply by */
    Panels restoring;    /* (k, 2 m): accelerations without products, from z folded */
    Panels acceleration; /* (k, r): accelerations due to loads */
    Panels push;         /* (m, r): acceleration of the modes that are parts alone, by their places, from the loads */
    double *push_p, *push_q; /* (m) likewise: what it adds to p' and q' */
    double *fold_p, *fold_q; /* (m) likewise: what p and q give to the restoring force, which stands in p's place */
    Sparse turn;             /* (3, 2 m): turn of the body due to eta */
    Sparse load_of_input;    /* (r, inputs) */
    Sparse load_of_internal; /* (r, 2 n + 6): from gyroscopic torques and momentum terms */
    Sparse gyroscopic;       /* (2 n, 3 + u): torque about a and b per axial momentum, from rate and slope rates */
    Sparse mount_speed;      /* (n, 6 + u): of wheels against inertial space, about their axes, less their own */
    Sparse output;           /* (6 + n + g + k, 6 + u + k + n + 9), as `output_map` of Python */
    Map integral;            /* scratch of `at_step` */
    double *driven, *of_load; /* (2 m, r), (6 + u, r): likewise */
} Motion;

/* For steps of one length. */
typedef struct PlantStep {
    double length;          /* s */
    Map whole, half;        /* of z over a step, and over half of one */
    Panels driven;          /* (2 m, r): z of the end, from the loads, but for the parts alone: those by */
    double *push_p, *push_q; /* (m) what a held acceleration adds to p and q over the step */
    Panels middle_of_load;  /* (6 + u, r): speeds at mid-step due to the loads, through z */
    double *end_of_load;    /* (6 + u, r): at the end, through momenta too */
    int braked;             /* wheels with friction; -1: not prepared */
    int *wheel;             /* (n) those with friction */
    double *torque_of_speed; /* (b, b) [N.m.s/rad]: coupled through the structure */
} PlantStep;

int prepare_motion(Component *component, Motion *motion);

/* Take memory for a length. */
int take_step(Component *component, const Motion *motion, PlantStep *step);

/* Prepare for steps of `length` [s], > 0, in memory that was taken. */
void at_step(Motion *motion, double length, PlantStep *step);

#endif
