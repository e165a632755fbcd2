/* Read the parameters of the exported controller. */
#ifndef FLEXSAT_PARAMETER_VALUES_H
#define FLEXSAT_PARAMETER_VALUES_H

#include "component.h"
#include "flexsat_controller.h"

/* Write them to the component's values; refuse one that lies outside its limits. */
int parameter_values(Component *component, const FlexsatParameters *parameters);

#endif
