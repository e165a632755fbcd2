/* Slew commands during a run: planned from the attitude that is there, queued, refused or replanned. The twin of
runtime/slew_commands.py, which documents it. */
#ifndef FLEXSAT_SLEW_COMMANDS_H
#define FLEXSAT_SLEW_COMMANDS_H

#include "commanded.h"

/* Accept a command, new or not; refuse a new one that would have to begin during a slew in flight, unless those are
to be replanned, or that begins or ends within a keep-out cone. */
int command(Component *component, const PreparedController *prepared, Commanded *state, double time,
            const double rotation[3], double start);

/* Begin with the turn, or the slew, that follows once the one in flight has ended. */
int proceed(Component *component, const PreparedController *prepared, Commanded *state, double time);

/* Count slews from this attitude, unless one has begun: where the spacecraft is when a run begins. Refuse if the slew
that is planned then begins or ends within a keep-out cone. */
int start_from(Component *component, const PreparedController *prepared, Commanded *state, double time,
               const double attitude[4]);

/* The reference attitude: from the origin about the axis, then what the modes turn the body across it; `quarter` is a
quarter of the rotation since. */
void reference_attitude(const double origin[4], const double axis[3], const double quarter[3], double attitude[4]);

#endif
