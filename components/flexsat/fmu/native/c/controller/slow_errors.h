/* Run-time filter of an external torque and of the gyros' biases, beside the filter of the state. The twin of
slow_errors.py and runtime/controller.py, which documents it. */
#ifndef FLEXSAT_SLOW_ERRORS_H
#define FLEXSAT_SLOW_ERRORS_H

#include <stdint.h>

#include "controller_parameters.h"
#include "controller_sizes.h"
#include "panels.h"

/* What a step uses. The gains are (9 + g, ..): attitude, rate, torque on the body, bias of each gyro. */
typedef struct SlowErrors {
    double period; /* s */
    int64_t phases; /* steps between two samples of the star tracker */
    const double *gyro_axis;      /* (g, 3) */
    const double *sample;         /* (9 + g, g + 3) */
    const double *between;        /* (9 + g, g) */
    double mobility[9];           /* inverse inertia [1/(kg.m2)] */
    double late[TORQUES * WHEELS];  /* torque on the body, of the wheels' torques of `whole_delay` steps before */
    double early[TORQUES * WHEELS]; /* of those of a step more before */
    Panels enters;  /* (s, 3): of the torque, in the state of the other filter, over a period */
    Panels ahead;   /* (r, 3): of the torque, until the wheels' torque acts */
    Panels against; /* (n, 3): torque of the wheels against that on the body */
} SlowErrors;

/* What the filter remembers: part of the saved state. */
typedef struct SlowState {
    double attitude[4]; /* body from inertial */
    double rate[3];     /* rad/s */
    double errors[SLOW]; /* torque on the body [N.m], bias of each gyro [rad/s]; 0 if not estimated */
} SlowState;

/* Whether the parameters choose to estimate some. */
int estimates_slow_errors(const ControllerParameters *parameters);

int slow_errors_take(Memory *memory, SlowErrors *slow);

/* Prepare for an allocation (n, 3) of a body torque among the wheels; `part` is of the period, at whose end a new
torque begins to act [s]. Returns 0, or 1 without memory. */
int slow_errors_prepare(Memory *memory, const ControllerData *matrices, const ControllerParameters *parameters,
                        const double *allocation, double part, SlowErrors *slow);

/* y += matrix (.., 3) times the estimated torque. */
void add_times_torque(const Panels *matrix, const SlowState *state, Real *y);

/* Propagate attitude and rate over a period with the torques of the wheels that acted. */
void slow_errors_predict(const SlowErrors *slow, const Real *late, const Real *early, SlowState *state);

/* Correct the estimate with measured rates and attitude; NULL if there is no new one. `steps` is how long ago the
sample of the star tracker before was. */
void slow_errors_correct(const SlowErrors *slow, const Real *gyro_rate, const double *seen, int64_t steps,
                         SlowState *state);

#endif
