/* Dry friction in the bearings of the wheels: the twin of runtime/bearing_friction.py. Over a step it is the constant
torque, of at most the given size, that brings the relative speed at the step's end nearest to zero. */
#ifndef FLEXSAT_BEARING_FRICTION_H
#define FLEXSAT_BEARING_FRICTION_H

#include "plant_step.h"

/* Prepare for the friction torques (n) [N.m], and the length in use; wheels of friction 0 turn freely. */
void prepare_friction(Plant *plant, const double *limits);

/* Add the friction of one step to the wheels' torques in `given`. `end` is z at the step's end without the loads, and
the state's loads are those of this step, with the internal ones of the step before. */
void add_friction(Plant *plant, const double *limits, const double *end);

/* Add what friction changes in the torques to their changes, (n), which make the change of the loads, (r). The present
torques, without friction, are in `given`; `load` is the present one with them. */
void add_friction_change(Plant *plant, const double *limits, const double *end, const double *load,
                         const double *load_change, double *torque_change);

/* Return the change of a value that is cut off at its least and its most; at a limit, on the side that the change points to. */
double change_within(double value, double least, double most, double change);

#endif
