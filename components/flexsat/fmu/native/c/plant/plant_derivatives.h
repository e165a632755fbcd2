/* Derivatives of the outputs that follow inputs. */
#ifndef FLEXSAT_PLANT_DERIVATIVES_H
#define FLEXSAT_PLANT_DERIVATIVES_H

#include "plant_step.h"

/* The accelerations' derivatives in a direction of inputs, with the state held: exact, as they are linear in the loads,
and these in the inputs between the limits of torque and friction. Arrays as in component_differentiate. */
void plant_differentiate(const Component *component, Plant *plant, const double *seed, double *change);

#endif
