/* What each version of FMI has of its own, for the code that all versions share: fmi2_host.c or fmi3_host.c. */
#ifndef BUNDLE_INTERFACE_H
#define BUNDLE_INTERFACE_H

#include "bundle.h"

extern const char host_mark; /* a host takes this character of a message for a beginning, unless there are two */

void host_message(const bundle_t *bundle, fmi2Status status, const char *category, const char *text);

#endif
