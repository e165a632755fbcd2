/* A rigid spacecraft with the sensors and wheels of the design, for the example: no noise, no modes, no jitter. */
#ifndef FLEXSAT_RIGID_SPACECRAFT_H
#define FLEXSAT_RIGID_SPACECRAFT_H

#include "flexsat_controller.h"
#include "data.h"

enum { MOST_WHEELS = 64 };

typedef struct RigidSpacecraft {
    double attitude[4];              /* quaternion, scalar-last, body from inertial */
    double rate[3];                  /* rad/s, body axes */
    double inverse[9];               /* of the inertia [1/(kg.m2)] */
    double wheel_speed[MOST_WHEELS]; /* rad/s, inertial, about the wheel's axis */
    double wheel_angle[MOST_WHEELS]; /* rad, within a turn */
    const ControllerData *design;
} RigidSpacecraft;

/* At rest, at the nominal wheel speeds. */
void spacecraft_start(RigidSpacecraft *spacecraft, const ControllerData *design);

/* Measure. The gyros sense x, y and z on the bus, then x and y at each site. */
void spacecraft_measure(const RigidSpacecraft *spacecraft, int star_tracker_valid, FlexsatInputs *inputs);

/* Move by a step [s] with these motor torques [N.m]. */
void spacecraft_move(RigidSpacecraft *spacecraft, const FlexsatReal *torque, double step);

#endif
