/* Motors of reaction wheels: the twin of runtime/motors.py, which documents it. */
#ifndef FLEXSAT_MOTORS_H
#define FLEXSAT_MOTORS_H

#include "plant_step.h"

/* The least and the greatest torque [N.m] of a wheel's motor at its present speed. */
void motor_range(const Plant *plant, int wheel, double *least, double *most);

/* Round commanded torques, (n), to the steps of the motors, and limit them. */
void drive_motors(const Plant *plant, double *torque);

#endif
