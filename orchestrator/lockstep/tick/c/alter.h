/* Faults that alter values before they are set. */
#ifndef LOCKSTEP_ALTER_H
#define LOCKSTEP_ALTER_H

#include "tick.h"

/* Execute an operation of one of the kinds TICK_ADD to TICK_DELAY_8 at a tick. */
void tick_alter(const tick_operation *op, int64_t tick);

#endif
