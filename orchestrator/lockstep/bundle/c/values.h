/* Set and get values of ports, and values of components behind them. */
#ifndef BUNDLE_VALUES_H
#define BUNDLE_VALUES_H

#include "bundle.h"

fmi2Status set_ports(bundle_t *bundle, int type, const fmi2ValueReference references[], size_t count,
                     const void *values);
fmi2Status get_ports(bundle_t *bundle, int type, const fmi2ValueReference references[], size_t count, void *values);

/* Refuse to set an output, or a fixed parameter after initialization; `reference` is the host's, for the message. */
fmi2Status refuse_set(const bundle_t *bundle, const port_t *port, uint32_t reference);

/* Have all components the values that the host has given since instantiation. */
fmi2Status set_given(bundle_t *bundle);

/* Give all ports their start values, as after instantiation. Return 0 if there is no memory. */
int start_ports(bundle_t *bundle);

void free_ports(bundle_t *bundle);

/* Return how a component's version names the function that sets or gets values of a type, without prefix. */
const char *access_call(const component_t *component, int set, int type);

/* Set or get values of a component, whatever its version, and judge the status. */
fmi2Status set_values(component_t *component, int type, const uint32_t *references, size_t count, const void *values);
fmi2Status get_values(component_t *component, int type, const uint32_t *references, size_t count, void *values);

/* Copy one row of outputs from the components themselves, or from the bus: at a communication point, and where a
component ended the simulation, before the samples of the tick. */
fmi2Status fetch_outputs(bundle_t *bundle);
void take_row(bundle_t *bundle);
void take_last_row(bundle_t *bundle);

#endif
