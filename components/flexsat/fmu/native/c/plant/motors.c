#include "motors.h"

#include <math.h>

void motor_range(const Plant *plant, int wheel, double *least, double *most)
{
    const PlantParameters *given = &plant->motion.parameters;
    const double limit = given->torque_limits[wheel], fastest = given->speed_limit[wheel];
    const double full = given->full_torque_speed[wheel], speed = plant->state.speed[wheel];
    double slope;

    *least = -limit;
    *most = limit;
    if (!(fastest > 0.0))
        return;
    /* the torque that reaches the limit in one step: a steeper fall would overshoot */
    slope = plant->motion.matrices.data->wheel_inertia[wheel] / plant->step->length;
    if (full > 0.0 && full < fastest)
        slope = fmin(limit / (fastest - full), slope);
    *most = fmin(fmax(slope * (fastest - speed), 0.0), limit);
    *least = -fmin(fmax(slope * (fastest + speed), 0.0), limit);
}

void drive_motors(const Plant *plant, double *torque)
{
    const double *step = plant->motion.parameters.torque_step;
    double least, most;
    int i;

    for (i = 0; i < plant->motion.matrices.wheels; i++) {
        if (step[i] > 0.0)
            torque[i] = step[i] * rint(torque[i] / step[i]);
        motor_range(plant, i, &least, &most);
        if (torque[i] > most)
            torque[i] = most;
        if (torque[i] < least)
            torque[i] = least;
    }
}
