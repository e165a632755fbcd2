/* The first harmonic of the wheels' imbalance: the twin of runtime/wheel_jitter.py. */
#ifndef FLEXSAT_WHEEL_JITTER_H
#define FLEXSAT_WHEEL_JITTER_H

#include "sines.h"

/* Write force a, force b [N], torque a, torque b [N.m] of n wheels, (4, n), held over `hold` [s] from now; speed [rad/s]
and angle [rad] of each now, and the coefficients of imbalance [N.s2/rad2], [N.m.s2/rad2]. */
void harmonic_jitter(Sines *sines, int n, const double *speed, const double *angle, double hold, double force,
                     double torque, double *jitter);

#endif
