/* The controller prepared for one run: its design sampled at the period, for the known delays. The twin of
runtime/prepared_controller.py, which documents it. */
#ifndef FLEXSAT_PREPARED_CONTROLLER_H
#define FLEXSAT_PREPARED_CONTROLLER_H

#include <stdint.h>

#include "controller_parameters.h"
#include "controller_sizes.h"
#include "null_motion.h"
#include "panels.h"
#include "sines.h"
#include "slew_guidance.h"
#include "slew_motion.h"
#include "slow_errors.h"

/* What no step changes. Where the Python stepper multiplies one matrix with stacked vectors, here are its blocks, so
that blocks of zeros cost nothing. The harmonic jitter of a wheel is made of two numbers, sine and cosine of its angle
times its speed squared; the matrices take these. */
typedef struct PreparedController {
    ControllerParameters parameters;
    double period; /* s */
    int phases;    /* of the gain: periods between two samples of the star tracker */
    int whole_delay; /* whole periods of both delays together */
    int64_t first_measurement; /* step that uses the first one */
    int delayed, smoothed, cancels_jitter;
    int knots; /* of a planned motion */
    int estimates_slow; /* torque on the body or gyro biases */
    SlowErrors slow;
    NullMotion null_motion;
    int optimal; /* slews are planned by the quadratic programme */
    Optimum *optimum; /* which works in this */
    KeepOut keep_out;
    SlewWheels slew_wheels; /* what each wheel may give to a slew */
    double wheel_inertia[WHEELS];    /* kg.m2 */
    double inertia[9];               /* kg.m2 */
    double nominal_speed[WHEELS];    /* rad/s */
    Shaper shaper;
    Panels c;              /* (y, s) */
    Panels *gain;          /* (phases) of (s, y) */
    Panels feedback;       /* (n, r) */
    Panels jitter_torque;  /* (n, 2 n): torque against the harmonic jitter */
    Panels predict;        /* (s, s): over a period, from the estimate */
    Panels predict_late;   /* (s, n): from the torques of `whole_delay` steps before */
    Panels predict_early;  /* (s, n): from those of a step more before */
    Panels predict_jitter; /* (s, 2 n) */
    Panels ahead;          /* (r, s): to the time at which the torque acts, from the estimate */
    Panels ahead_history;  /* (r, (q + 2) n): and from the torques commanded */
    Panels reference_a;    /* (r, r) */
    Panels reference_b;    /* (r, n) */
    Sines *sines;          /* for this processor */
} PreparedController;

/* Sample the models of a design for the delays of a run. Returns 0, or 1 without memory or with the reason. */
int prepare_controller(Component *component, const ControllerData *matrices, const ControllerParameters *parameters,
                       PreparedController *prepared);

#endif
