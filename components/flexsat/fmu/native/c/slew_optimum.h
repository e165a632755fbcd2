/* A slew as the optimum of the paper's quadratic programme, by an interior-point method. The twin of
runtime/slew_optimum.py, which documents it. */
#ifndef FLEXSAT_SLEW_OPTIMUM_H
#define FLEXSAT_SLEW_OPTIMUM_H

#include "memory.h"

enum {
    OPTIMUM_STEPS = 200, /* of constant torque */
    OPTIMUM_KNOTS = OPTIMUM_STEPS + 1,
    OPTIMUM_BOUNDS = 4 * OPTIMUM_STEPS - 2 /* inequalities */
};

#define OPTIMUM_TAIL 12.0 /* s after the shortest time: it comes to rest with the time constant of the rate weight */

/* What the method works in; a planned slew needs it no more. */
typedef struct Optimum {
    double steps[OPTIMUM_STEPS];    /* s */
    double unit[OPTIMUM_STEPS];     /* change of rate over a step at the greatest acceleration, in slew angles */
    double most;                    /* rate, in slew angles [1/s] */
    double *quadratic;              /* (n, n), half of the cost's second derivative is this */
    double *factor;                 /* (n, n), of the system's Cholesky factor; before, angles of changes of rate */
    double linear[OPTIMUM_STEPS];
    double end[2 * OPTIMUM_STEPS];  /* (2, n): angle and rate at the end */
    double on[2], end_value[2];
    double x[OPTIMUM_STEPS], stationary[OPTIMUM_STEPS];
    double slack[OPTIMUM_BOUNDS], dual[OPTIMUM_BOUNDS], bounds[OPTIMUM_BOUNDS];
    double inside[OPTIMUM_BOUNDS], ratio[OPTIMUM_BOUNDS], complementary[OPTIMUM_BOUNDS];
    double multiplier[2];
    double along_end[2 * OPTIMUM_STEPS]; /* (2, n): inverse of the system times those of the end */
    double square[3];                    /* of the Schur complement: 11, 12, 22 */
    double dx[OPTIMUM_STEPS], ds[OPTIMUM_BOUNDS], dz[OPTIMUM_BOUNDS], dy[2];
} Optimum;

/* Take memory; returns NULL without it. */
Optimum *optimum_take(Memory *memory);

/* The knots [s] from 0 to beyond the shortest duration; dense where the torque changes. */
void optimum_times(double duration, double ramp, double times[OPTIMUM_KNOTS]);

/* The rates [rad/s] at the knots of the optimal turn by an angle [rad] from an initial rate [rad/s] to rest, within
acceleration [rad/s2] and rate [rad/s]; returns 0, or 1 if the method finds no optimum. */
int optimal_rates(Optimum *work, double angle, double acceleration, double rate, const double times[OPTIMUM_KNOTS],
                  double initial, double rates[OPTIMUM_KNOTS]);

#endif
