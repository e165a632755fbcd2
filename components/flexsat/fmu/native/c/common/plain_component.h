/* Life cycle of a component without tunable parameters and without outputs that follow inputs or are computed on demand:
component_tuned, component_follow_inputs and component_evaluate of component.h, which do nothing. */
#ifndef FLEXSAT_PLAIN_COMPONENT_H
#define FLEXSAT_PLAIN_COMPONENT_H

#include <stddef.h>

#include "component.h"

/* Take zeroed memory for `own` and `state` of these sizes [bytes], at the start of a run with steps of any length. */
int take_component_memory(Component *component, size_t own, size_t state);

#endif
