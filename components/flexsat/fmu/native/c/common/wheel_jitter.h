/* Harmonics of the wheels' imbalance: the twin of runtime/wheel_jitter.py. */
#ifndef FLEXSAT_WHEEL_JITTER_H
#define FLEXSAT_WHEEL_JITTER_H

#include "sines.h"

/* Write force a, force b [N], torque a, torque b [N.m] of n wheels, (4, n), held over `hold` [s] from now; speed [rad/s]
and angle [rad] of each now, and the coefficients of imbalance [N.s2/rad2], [N.m.s2/rad2]. */
void harmonic_jitter(Sines *sines, int n, const double *speed, const double *angle, double hold, const double *force,
                     const double *torque, double *jitter);

/* Harmonics beside the first, (p, n) each: multiples of the wheel's angle, coefficients as above, phases [rad]. */
typedef struct Harmonics {
    int count; /* p */
    const double *order, *force, *torque, *phase;
} Harmonics;

/* Add their jitter; `factor` (n) multiplies the harmonics of each wheel, and `scratch` holds 3 n doubles. */
void add_harmonics(const Harmonics *harmonics, Sines *sines, int n, const double *speed, const double *angle,
                   double hold, const double *factor, double *scratch, double *jitter);

#endif
