/* Motions and turns within the limits of a controller: the twin of the planning in runtime/prepared_controller.py. */
#ifndef FLEXSAT_SLEW_PLANS_H
#define FLEXSAT_SLEW_PLANS_H

#include "prepared_controller.h"

/* Refuse a slew whose shaped torque would have to begin before the run, or before the first measurement can count it;
a slew of no angle is none. */
int check_start(Component *component, const PreparedController *prepared, double angle, double start);

/* Plan the motion for a rotation vector [rad] from `start` [s] on, from rest; refuse if there is none. */
int plan_motion(Component *component, const PreparedController *prepared, const double rotation[3], double start,
                Motion *motion);

/* The turns [rad] of a slew from an attitude: one, or several round the keep-out cones; refuse if there are none. */
int plan_turns(Component *component, const PreparedController *prepared, const double attitude[4],
               const double rotation[3], double turns[LEGS][3]);

/* How long a turn by a rotation vector [rad] takes [s], with the pause after it; 0 for no turn. */
double duration_of(const PreparedController *prepared, const double turn[3]);

/* The shortest time between two slews [s]: for the shaped torque of both. */
double pause_between(const PreparedController *prepared);

/* Brake a motion in flight from a sample at `time` [s] on. */
void brake(const PreparedController *prepared, double time, Motion *motion);

/* Turn a motion in flight on to another angle [rad], by the programme from the rate at `time` [s]. Returns 0 if it
cannot: the angle lies behind, or before the end of braking, or the programme has no optimum. */
int turn_on(const PreparedController *prepared, double time, double angle, Motion *motion);

#endif
