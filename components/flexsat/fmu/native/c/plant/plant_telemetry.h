/* Quantities for the engineer, computed on demand. */
#ifndef FLEXSAT_PLANT_TELEMETRY_H
#define FLEXSAT_PLANT_TELEMETRY_H

#include "plant_step.h"

/* Write the outputs on demand. */
void plant_telemetry(Component *component, Plant *plant);

/* Add the wheels' momenta about axes that are tilted with the structure, to second order in eta, (m) (PHYSICS section
2). */
void add_wheels(const Plant *plant, const double *eta, double momentum[3]);

#endif
