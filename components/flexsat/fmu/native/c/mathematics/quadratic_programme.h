/* The quadratic programme of a slew about one axis, by an interior-point method: that of runtime/slew_optimum.py. */
#ifndef FLEXSAT_QUADRATIC_PROGRAMME_H
#define FLEXSAT_QUADRATIC_PROGRAMME_H

#include "memory.h"

enum {
    OPTIMUM_STEPS = 200, /* of constant torque */
    OPTIMUM_KNOTS = OPTIMUM_STEPS + 1,
    OPTIMUM_BOUNDS = 4 * OPTIMUM_STEPS - 2 /* inequalities */
};

/* What the method works in; a planned slew needs it no more. */
typedef struct Optimum {
    double steps[OPTIMUM_STEPS];    /* s */
    double unit[OPTIMUM_STEPS];     /* change of rate over a step at the greatest acceleration, in slew angles */
    double most;                    /* rate, in slew angles [1/s] */
    double *quadratic;              /* (n, n): second derivative of the cost */
    double *factor;                 /* (n, n), of the system's Cholesky factor; before, angles of changes of rate */
    double linear[OPTIMUM_STEPS];   /* first derivative of the cost at 0 */
    double end[2 * OPTIMUM_STEPS];  /* (2, n): angle and rate at the end */
    double end_value[2];            /* that they are to have */
    double x[OPTIMUM_STEPS], stationary[OPTIMUM_STEPS];
    double slack[OPTIMUM_BOUNDS], dual[OPTIMUM_BOUNDS], bounds[OPTIMUM_BOUNDS];
    double inside[OPTIMUM_BOUNDS], ratio[OPTIMUM_BOUNDS], complementary[OPTIMUM_BOUNDS];
    double on[2], multiplier[2];
    double along_end[2 * OPTIMUM_STEPS]; /* (2, n): inverse of the system times those of the end */
    double square[3];                    /* of the Schur complement: 11, 12, 22 */
    double dx[OPTIMUM_STEPS], ds[OPTIMUM_BOUNDS], dz[OPTIMUM_BOUNDS], dy[2];
} Optimum;

/* Take memory; returns NULL without it. */
Optimum *optimum_take(Memory *memory);

/* Rates at the knots 1..n of changes of rate, both over their bounds or in slew angles: y = R x. */
void to_rates(const Optimum *work, const double *x, double *y);

/* Minimise x^T h x / 2 + g^T x over c x <= d, e x = f (Nocedal and Wright, Numerical Optimization, section 16.6). */
int minimise(Optimum *work);

#endif
