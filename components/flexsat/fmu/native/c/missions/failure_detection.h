/* Wheels that do not follow their torque, and the torque of those that do: the twin of
runtime/missions/failure_detection.py and runtime/missions/allocation.py. */
#ifndef FLEXSAT_FAILURE_DETECTION_H
#define FLEXSAT_FAILURE_DETECTION_H

#include <stdint.h>

#include "ports.h"

#define WHEELS PORT_ENCODER_SPEED_SIZE

enum { WORKS, OFF, SEIZED }; /* of a wheel */

typedef struct PreparedDetection {
    int enabled;
    const double *wheel_inertia; /* (n,) */
    double step, follow, threshold, seized_speed, braking_time;
    int64_t persistence;
} PreparedDetection;

typedef struct DetectionState {
    double expected[WHEELS], answered[WHEELS], given[WHEELS], residual[WHEELS];
    int64_t beyond[WHEELS], status[WHEELS];
} DetectionState;

void detect_failures(const PreparedDetection *prepared, DetectionState *state, int first, const double *torque,
                     const double *speed);

/* (E^T E)^-1 of the wheels that work, or zeros; returns 1 if they give no torque about some axis. */
int inverse_of_axes(const double *axis, const int64_t *status, double inverse[3][3]);

#endif
