/* The FMUs of a bundle: their libraries and instances. */
#ifndef BUNDLE_COMPONENTS_H
#define BUNDLE_COMPONENTS_H

#include "bundle.h"

/* Load and instantiate all; report and return fmi2Error if one cannot be. */
fmi2Status load_components(bundle_t *bundle);

/* Free all instances that may still be called, and unload their libraries. */
void unload_components(bundle_t *bundle);

/* Call fmi2SetDebugLogging of one. */
fmi2Status log_component(component_t *component, int on);

/* Return the worse of two statuses, as FMI orders them. */
fmi2Status worse(fmi2Status one, fmi2Status other);

#endif
