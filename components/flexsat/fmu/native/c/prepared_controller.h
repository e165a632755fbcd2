/* The controller prepared for one run: its design sampled at the period, for the known delays. The twin of
runtime/prepared_controller.py, which documents it. */
#ifndef FLEXSAT_PREPARED_CONTROLLER_H
#define FLEXSAT_PREPARED_CONTROLLER_H

#include <stdint.h>

#include "controller_parameters.h"
#include "controller_sizes.h"
#include "panels.h"
#include "slew_guidance.h"
#include "slew_motion.h"

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
    double wheel_inertia;            /* kg.m2 */
    double inertia[9];               /* kg.m2 */
    double nominal_speed[WHEELS];    /* rad/s */
    double distribution[WHEELS * 3]; /* wheel torques of a body torque */
    double body_torque[3];           /* N.m that the slew may use */
    double body_momentum[3];         /* N.m.s */
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
} PreparedController;

/* Sample the models of a design for the delays of a run. Returns 0, or 1 without memory. */
int prepare_controller(Memory *memory, const ControllerData *matrices, const ControllerParameters *parameters,
                       PreparedController *prepared);

/* Refuse a slew whose shaped torque would have to begin before the run, or before the first measurement can count it;
a slew of no angle is none. */
int check_start(Component *component, const PreparedController *prepared, double angle, double start);

/* Plan the motion for a rotation vector [rad] from `start` [s] on, from rest; refuse if there is none. */
int plan_motion(Component *component, const PreparedController *prepared, const double rotation[3], double start,
                Motion *motion);

/* The greatest acceleration [rad/s2] of a slew about an axis. */
double acceleration_about(const PreparedController *prepared, const double axis[3]);

#endif
