/* Whether exchanged values are finite. */
#ifndef BUNDLE_FINITE_H
#define BUNDLE_FINITE_H

#include "bundle.h"

static inline int is_finite(double value)
{
    return value - value == 0.0; /* without the functions behind isfinite() of some C libraries */
}

/* Refuse fetched values that a connection reads and that are not finite; they are true at the end of a tick. */
fmi2Status check_finite(const component_t *component, const get_t *get, const double *values, int64_t tick);

#endif
