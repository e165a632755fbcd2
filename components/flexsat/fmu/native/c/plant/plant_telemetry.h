/* Quantities for the engineer, computed on demand. */
#ifndef FLEXSAT_PLANT_TELEMETRY_H
#define FLEXSAT_PLANT_TELEMETRY_H

#include "plant_step.h"

/* Write the outputs on demand. */
void plant_telemetry(Component *component, Plant *plant);

#endif
