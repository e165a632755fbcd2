#include "rigid_spacecraft.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"
#include "rotations.h"

#define TURN 6.28318530717958648

void spacecraft_start(RigidSpacecraft *spacecraft, const ControllerData *design)
{
    double inertia[9];

    memset(spacecraft, 0, sizeof *spacecraft);
    spacecraft->design = design;
    spacecraft->attitude[3] = 1.0;
    memcpy(inertia, design->inertia, sizeof inertia);
    invert(3, inertia, spacecraft->inverse);
    memcpy(spacecraft->wheel_speed, design->nominal_speed, (size_t)design->nominal_speed_rows * sizeof(double));
}

void spacecraft_measure(const RigidSpacecraft *spacecraft, int star_tracker_valid, FlexsatInputs *inputs)
{
    const ControllerData *design = spacecraft->design;
    const double *rate = spacecraft->rate;
    int k;

    for (k = 0; k < design->gyros; k++)
        inputs->gyro_rate[k] = (FlexsatReal)rate[k < 3 ? k : (k - 3) % 2];
    for (k = 0; k < design->nominal_speed_rows; k++) {
        const double *axis = design->wheel_axis + 3 * k;
        const double along = axis[0] * rate[0] + axis[1] * rate[1] + axis[2] * rate[2];
        inputs->encoder_speed[k] = (FlexsatReal)(spacecraft->wheel_speed[k] - along);
        inputs->encoder_angle[k] = (FlexsatReal)spacecraft->wheel_angle[k];
    }
    inputs->star_tracker_valid = star_tracker_valid;
    if (star_tracker_valid)
        mrp_from_quaternion(spacecraft->attitude, inputs->star_tracker_mrp);
}

void spacecraft_move(RigidSpacecraft *spacecraft, const FlexsatReal *torque, double step)
{
    const ControllerData *design = spacecraft->design;
    double body[3] = {0.0, 0.0, 0.0}, change[3], turn[3];
    int k;

    for (k = 0; k < design->nominal_speed_rows; k++) {
        const double *axis = design->wheel_axis + 3 * k;
        const double faster = torque[k] / design->wheel_inertia[k] * step;
        body[0] -= axis[0] * torque[k];
        body[1] -= axis[1] * torque[k];
        body[2] -= axis[2] * torque[k];
        spacecraft->wheel_angle[k] =
            fmod(spacecraft->wheel_angle[k] + (spacecraft->wheel_speed[k] + 0.5 * faster) * step, TURN);
        spacecraft->wheel_speed[k] += faster;
    }
    times_vector(3, 3, spacecraft->inverse, body, change);
    for (k = 0; k < 3; k++) {
        turn[k] = (spacecraft->rate[k] + 0.5 * change[k] * step) * step;
        spacecraft->rate[k] += change[k] * step;
    }
    rotate_quaternion(spacecraft->attitude, turn, spacecraft->attitude);
}
