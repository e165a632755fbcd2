/* The controller's parameters of one run: the twin of runtime/controller_parameters.py and ports/controller.py. */
#ifndef FLEXSAT_CONTROLLER_PARAMETERS_H
#define FLEXSAT_CONTROLLER_PARAMETERS_H

#include "component.h"
#include "controller_sizes.h"
#include "data.h"
#include "keep_out.h"

typedef enum Guidance { BANG_COAST_BANG, SMOOTHED, QUADRATIC_PROGRAMME } Guidance;

typedef struct ControllerParameters {
    int fine_sensor;
    int feed_forward_jitter;
    int smoothed;             /* slew reference: smoothed instead of time-optimal */
    int open_loop;            /* estimates, but commands no torque */
    double torque_limit;      /* N.m */
    double speed_band;        /* rad/s either side of nominal */
    double authority;         /* share of torque and speed band that the slew may use */
    double measurement_delay; /* s, from sampling to the call that uses it; known, whole milliseconds */
    double actuation_delay;   /* s, from the call to when the torque acts */
    double imbalance_force[WHEELS];  /* N.s2/rad2 */
    double imbalance_torque[WHEELS]; /* N.m.s2/rad2 */
    Guidance guidance;
    int replans;              /* a command during a slew replaces it, else it is refused */
    double capture_angle;     /* rad */
    double torque_limits[WHEELS]; /* N.m, of each wheel */
    double speed_bands[WHEELS];   /* rad/s, of each wheel */
    double speed_offset[WHEELS];  /* rad/s, at rest less the nominal one */
    int gyroscopic;               /* count the gyroscopic torque of wheels and body in the feed-forward of slews */
    int least_peak;               /* divide the torque of slews by the least peak of the wheels' shares */
    KeepOut keep_out;
    int estimates_torque;     /* an external torque on the body, and compensates it */
    int estimates_bias;       /* the bias of each gyro */
    double null_rate;         /* 1/s, of wheels' motion without torque on the body; 0: none */
    int linear_attitude;      /* attitudes as sums of a quarter of the angle, as the published release has them */
} ControllerParameters;

/* Read and check them; `matrices` becomes the design that they choose. Returns 0, or 1 with the reason in
`message`. */
int controller_parameters(Component *component, const ControllerData **matrices, ControllerParameters *parameters);

#endif
