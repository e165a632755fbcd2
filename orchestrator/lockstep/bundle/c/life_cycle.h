/* The life of a bundle, as all versions of FMI have it. `call` is how the host's version names a function. */
#ifndef BUNDLE_LIFE_CYCLE_H
#define BUNDLE_LIFE_CYCLE_H

#include "bundle.h"

/* NULL: there is no memory. Resources are set next, then the bundle is opened. */
bundle_t *new_bundle(const char *name, const host_t *host, int logging);
void free_bundle(bundle_t *bundle);

/* Read the program and load all components; `what` is how the host's version names the token. */
fmi2Status open_bundle(bundle_t *bundle, const char *what, const char *token);

fmi2Status set_experiment(bundle_t *bundle, const char *call, int tolerance_defined, double tolerance, double start,
                          int stop_defined, double stop);
fmi2Status enter_initialization(bundle_t *bundle, const char *call);
fmi2Status exit_initialization(bundle_t *bundle, const char *call);

/* fmi2Discard: the step is not complete, or `ended` says that a component asked for the end. */
fmi2Status make_step(bundle_t *bundle, const char *call, double time, double step);
fmi2Status terminate_bundle(bundle_t *bundle, const char *call);
fmi2Status reset_bundle(bundle_t *bundle, const char *call);
fmi2Status set_logging(bundle_t *bundle, const char *call, int on);

#endif
