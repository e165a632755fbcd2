/* Run-time LQG flight controller: periodic Kalman filter, slew reference, regulator, saturation, known delays. The
twin of runtime/controller.py, which documents it. One step is one period. */
#ifndef FLEXSAT_CONTROLLER_LAW_H
#define FLEXSAT_CONTROLLER_LAW_H

#include "slew_commands.h"

/* Inputs of a step. */
typedef struct Measurements {
    const Real *gyro_rate;          /* (g) [rad/s] */
    const Real *accelerometer;      /* (k) [m/s2] */
    const Real *encoder_speed;      /* (n) [rad/s] */
    const Real *encoder_angle;      /* (n) [rad] */
    const double *star_tracker_mrp; /* (3), a double: see real.h */
    int star_tracker_valid;         /* a new sample */
    const Real *applied_torque;     /* (n) [N.m], commanded in the step before by the controller in control */
    int applied_valid;              /* applied_torque is given; else it was this controller's */
} Measurements;

/* Hold from the sampling time on; written by a step. */
typedef struct ControllerOutputs {
    Real *torque;           /* (n) [N.m] */
    Real *estimate;         /* (r), that the torque was made from */
    Real *reference;        /* (r) */
    Real *reference_torque; /* (n) [N.m] */
    Real *slow_errors;      /* (3 + g): estimated torque on the body [N.m], and bias of each gyro [rad/s] */
} ControllerOutputs;

/* What the controller remembers between steps, all that is saved; of variable size. */
typedef struct ControllerState {
    int64_t count; /* steps done */
    int64_t held;  /* calls since the last step, itself included, where there are several calls to a period */
    int64_t since_star_tracker; /* steps */
    Real estimate[STATES];      /* at the time of the last measurement */
    double attitude[4];         /* body from inertial; the estimate's first three turn it further */
    Real jitter[2 * WHEELS];    /* expected over the coming period: sines and cosines, times speed squared */
    SlowState slow;
    Commanded commanded;
    Real history[]; /* (q + 2, n): torques commanded, the latest first [N.m] */
} ControllerState;

size_t controller_state_size(const PreparedController *prepared); /* bytes */

/* The state at the start of a run, at rest at the nominal wheel speeds, with a slew planned; refuse if the shaped
torque would have to begin before the run. The state is zero before. */
int controller_init(Component *component, const PreparedController *prepared, const double rotation[3], double start,
                    ControllerState *state);

/* Count a call, `calls` of them to a period; return whether a step is due in it. */
int controller_is_due(ControllerState *state, int64_t calls);

/* Correct the estimate with what was measured, and command the torque; refuse a slew that leads into a keep-out cone.
`time` is that of this call [s]. */
int controller_step(Component *component, const PreparedController *prepared, ControllerState *state, double time,
                    const Measurements *measured, const ControllerOutputs *outputs);

#endif
