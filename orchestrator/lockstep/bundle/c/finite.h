/* Whether exchanged values are finite. */
#ifndef BUNDLE_FINITE_H
#define BUNDLE_FINITE_H

#include "bundle.h"

static inline int is_finite(double value)
{
    return value - value == 0.0; /* without the functions behind isfinite() of some C libraries */
}

/* Refuse values that are not finite: converted ones, and fetched ones that a connection reads, which are true at the
beginning of a tick. */
fmi2Status refuse_converted(const component_t *component, uint32_t target, double value);
fmi2Status check_converted(const component_t *component, const set_t *set, const double *values);
fmi2Status check_finite(const component_t *component, const get_t *get, const double *values, int64_t tick);

#endif
