/* States of a bundle: those of its components, the bus, and the values of its ports. `call` is for messages. */
#ifndef BUNDLE_STATES_H
#define BUNDLE_STATES_H

#include "bundle.h"

fmi2Status get_state(bundle_t *bundle, const char *call, fmi2FMUstate *state);
fmi2Status set_state(bundle_t *bundle, const char *call, fmi2FMUstate state);
fmi2Status free_state(bundle_t *bundle, const char *call, fmi2FMUstate *state);
fmi2Status state_size(bundle_t *bundle, const char *call, fmi2FMUstate state, size_t *size);
fmi2Status serialize(bundle_t *bundle, const char *call, fmi2FMUstate state, void *bytes, size_t size);
fmi2Status deserialize(bundle_t *bundle, const char *call, const void *bytes, size_t size, fmi2FMUstate *state);

/* Free all states that the host has not. */
void free_states(bundle_t *bundle);

#endif
