/* Exact sampling of linear systems whose inputs are held: the twin of runtime/zero_order_hold.py. */
#ifndef FLEXSAT_ZERO_ORDER_HOLD_H
#define FLEXSAT_ZERO_ORDER_HOLD_H

#include "memory.h"

/* exp(a t) at t = period [s] and its integral from 0 to the period, (n, n) each; returns 0, or 1 without memory. */
int transition(Memory *memory, int n, const double *a, double period, double *exponential, double *integral);

/* The same in given memory: `work` holds 3 n n doubles. */
void transition_with(int n, const double *a, double period, double *exponential, double *integral, double *work);

/* x[k + 1] = ad x[k] + bd u[k] for x' = a x + b u: a (n, n), b (n, m); returns 0, or 1 without memory. */
int zero_order_hold(Memory *memory, int n, int m, const double *a, const double *b, double period, double *ad,
                    double *bd);

#endif
