/* A slew as the optimum of the paper's quadratic programme, by an interior-point method. The twin of
runtime/slew_optimum.py, which documents it. */
#ifndef FLEXSAT_SLEW_OPTIMUM_H
#define FLEXSAT_SLEW_OPTIMUM_H

#include "quadratic_programme.h"

#define OPTIMUM_TAIL 12.0 /* s after the shortest time: it comes to rest with the time constant of the rate weight */

/* The knots [s] from 0 to beyond the shortest duration; dense where the torque changes. */
void optimum_times(double duration, double ramp, double times[OPTIMUM_KNOTS]);

/* The rates [rad/s] at the knots of the optimal turn by an angle [rad] from an initial rate [rad/s] to rest, within
acceleration [rad/s2] and rate [rad/s]; returns 0, or 1 if the method finds no optimum. */
int optimal_rates(Optimum *work, double angle, double acceleration, double rate, const double times[OPTIMUM_KNOTS],
                  double initial, double rates[OPTIMUM_KNOTS]);

#endif
