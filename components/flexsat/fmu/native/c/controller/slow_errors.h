/* Run-time estimate of an external torque and of the gyros' biases beside the filter's state. The twin of
runtime/slow_errors.py, which documents it. */
#ifndef FLEXSAT_SLOW_ERRORS_H
#define FLEXSAT_SLOW_ERRORS_H

#include "controller_parameters.h"
#include "controller_sizes.h"
#include "panels.h"

/* What a step uses of c: torque on the body (3), then the bias of each gyro. */
typedef struct SlowErrors {
    Panels gain;    /* (k, y): of the innovation at a sample of the star tracker */
    Panels shift;   /* (s, k): change of the state's estimate for a change of c then */
    Panels enters;  /* (s, 3): of the torque, over a period */
    Panels ahead;   /* (r, 3): of the torque, to the time at which the wheels' torque acts */
    Panels against; /* (n, 3): torque of the wheels against that on the body */
} SlowErrors;

/* Whether the parameters choose to estimate some. */
int estimates_slow_errors(const ControllerParameters *parameters);

int slow_errors_take(Memory *memory, SlowErrors *slow);

/* Prepare for an allocation (n, 3) of a body torque among the wheels. Returns 0, or 1 without memory. */
int slow_errors_prepare(Memory *memory, const ControllerData *matrices, const ControllerParameters *parameters,
                        const double *allocation, SlowErrors *slow);

/* Add what the torque does to the state over a period. */
void slow_errors_predict(const SlowErrors *slow, const Real *errors, Real *estimate);

/* Correct c with the innovation at a sample of the star tracker, and the state by what that changes. */
void slow_errors_correct(const SlowErrors *slow, const Real *innovation, Real *errors, Real *estimate);

#endif
