/* Division of a body torque between redundant wheels by the least peak: the twin of `least_peak` in
flexsat/allocation.py, which documents it. */
#ifndef FLEXSAT_ALLOCATION_H
#define FLEXSAT_ALLOCATION_H

#include "controller_sizes.h"

/* Wheel torques (n) of a body torque whose largest shares of the limits (n) are the least; axes (n, 3). The wheels that
have a limit must turn the body about all axes. */
void least_peak(const double *axes, const double *limits, const double torque[3], double *result);

#endif
