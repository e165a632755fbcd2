/* Initialise the components, in the order and with the values of lockstep/run/initialise.py. */
#ifndef BUNDLE_INITIALISE_H
#define BUNDLE_INITIALISE_H

#include "bundle.h"

/* Announce the experiment, set start values, and enter initialization mode. */
fmi2Status begin_initialization(bundle_t *bundle);

/* Set the inputs of components from outputs of others as they are in initialization mode. */
fmi2Status propagate(bundle_t *bundle);

/* Leave initialization mode, one component after the other, and fill the bus. */
fmi2Status complete_initialization(bundle_t *bundle);

#endif
