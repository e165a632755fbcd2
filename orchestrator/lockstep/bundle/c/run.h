/* Run ticks. */
#ifndef BUNDLE_RUN_H
#define BUNDLE_RUN_H

#include "bundle.h"

/* Take the samples at the first communication point; outputs are then those at the start time. */
fmi2Status run_to_start(bundle_t *bundle);

/* Run so many ticks; outputs are then those at the end of the last one. */
fmi2Status run_ticks(bundle_t *bundle, int64_t count);

#endif
