/* Which saved states a controller can go on from. */
#ifndef FLEXSAT_CONTROLLER_SAVED_H
#define FLEXSAT_CONTROLLER_SAVED_H

#include "controller_law.h"

/* Whether a state is one that a controller reaches: counts and places in it lead nowhere outside. */
int is_reachable(const PreparedController *prepared, const ControllerState *state);

#endif
