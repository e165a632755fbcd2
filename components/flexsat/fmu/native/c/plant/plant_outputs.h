/* What is observed of the plant, and what it feeds back: the second half of the preparation of a motion. */
#ifndef FLEXSAT_PLANT_OUTPUTS_H
#define FLEXSAT_PLANT_OUTPUTS_H

#include "prepared_plant.h"

int prepare_outputs(Component *component, Motion *motion);

#endif
