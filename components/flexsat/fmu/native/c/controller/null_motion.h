/* Motion of redundant wheels that gives the body no torque: the twin of `NullMotion` in flexsat/allocation.py. */
#ifndef FLEXSAT_NULL_MOTION_H
#define FLEXSAT_NULL_MOTION_H

#include "controller_parameters.h"
#include "controller_sizes.h"

typedef struct NullMotion {
    double rate;             /* 1/s: of what is left to the least peak */
    double axes[3 * WHEELS]; /* (n, 3); zero for wheels that have no torque, which take no part */
    double inverse[9];       /* of the sum of axis times axis */
    double limits[WHEELS];   /* N.m.s: momentum that each wheel may have beside the nominal one */
} NullMotion;

/* The wheels that work must turn the body about all axes. */
void prepare_null_motion(const ControllerData *matrices, const ControllerParameters *parameters, NullMotion *motion);

/* Torques (n) towards the least peak of the shares of the limits; least and most (n) are what each wheel has left. */
void null_torque(const NullMotion *motion, const double *momenta, const double *least, const double *most,
                 double *torque);

#endif
