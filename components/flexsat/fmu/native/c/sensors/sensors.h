/* What the sensors keep. */
#ifndef FLEXSAT_SENSORS_H
#define FLEXSAT_SENSORS_H

#include <stdint.h>

#include "panels.h"
#include "ports.h"
#include "random.h"
#include "sensor_errors.h"
#include "sensor_parameters.h"
#include "sines.h"
#include "wheel_jitter.h"

#define WRENCHES (6 * PORT_JITTER_FORCE_X_SIZE) /* their ports stand one after the other */

/* The filter sampled for one step length, and the numbers of one run; no step changes them. */
typedef struct PreparedSensors {
    SensorParameters parameters;
    SensorErrors errors;     /* beside white noise */
    double transition[2][4]; /* from the four rows of the filter to its next output and rate */
    double deviation[GYROS + ACCELEROMETERS + WHEELS];
    double broadband_deviation[4 * WHEELS];
    Sparse wrench_of_jitter; /* a wheel acts on its own mount alone */
    Sines *sines;            /* for this processor */
    Harmonics harmonics;     /* beside the first */
} PreparedSensors;

/* What the sensors remember between steps beside their outputs, which the ports hold. */
typedef struct SensorState {
    int64_t count;                    /* steps done */
    Random noise, disturbance;
    ErrorState errors;
    double filter[3][ACCELEROMETERS]; /* m/s2: output, its rate over the corner frequency, last input */
    double broadband[4 * WHEELS];     /* noise part of force a, force b [N], torque a, torque b [N.m] of each wheel */
} SensorState;

#endif
