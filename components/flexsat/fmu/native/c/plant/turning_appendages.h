/* Appendages that turn: the matrices at their present angles; the twin of runtime/turning/angles.py. */
#ifndef FLEXSAT_TURNING_APPENDAGES_H
#define FLEXSAT_TURNING_APPENDAGES_H

#include "plant_parameters.h"

/* The angles of the appendages that turn, (t) [rad]; NULL if none does. */
const double *appendage_angles(const Component *component);

/* Turn what stands at the angles of the file to the present ones. */
int turn_appendages(Component *component, PlantMatrices *matrices);

#endif
