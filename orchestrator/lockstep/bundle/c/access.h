/* What a host may read and write when: values of ports by their numbers, and states. */
#ifndef BUNDLE_ACCESS_H
#define BUNDLE_ACCESS_H

#include "bundle.h"

/* Whether values may be set or read now, and the arrays are there; a message if not. */
int may_set(const bundle_t *bundle, const char *call, size_t count, const void *references, const void *values);
int may_get(const bundle_t *bundle, const char *call, size_t count, const void *references, const void *values);

/* Whether the state may be asked for or set; a message if not. */
int may_have_state(const bundle_t *bundle, const char *call, const void *given);

/* Return the status that the host gets: a fatal failure of a component is one of the bundle. */
fmi2Status noted_fatal(const bundle_t *bundle, fmi2Status status);

#endif
