/* A command during a slew replaces it. Part of the twin of runtime/slew_commands.py. */
#ifndef FLEXSAT_SLEW_REPLAN_H
#define FLEXSAT_SLEW_REPLAN_H

#include "commanded.h"

/* Turn to where the command leads from the attitude at which the slew in flight began: the turn in flight is braked,
or with the quadratic programme goes on, if the command is then reached earlier. */
int replan(Component *component, const PreparedController *prepared, Commanded *state, double time,
           const double rotation[3], double start);

#endif
