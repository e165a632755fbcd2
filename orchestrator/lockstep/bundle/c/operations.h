/* The operations of the tick in C (lockstep/tick/c/tick.h) that a program becomes. */
#ifndef BUNDLE_OPERATIONS_H
#define BUNDLE_OPERATIONS_H

#include "bundle.h"

/* Make the operations of a program that has been read; return 0 if there is no memory. */
int make_operations(bundle_t *bundle);

/* Have the operations call the instances of the components, which are loaded. */
void bind_operations(bundle_t *bundle);

/* Put the tick to its mark, where a communication point is. */
void go_to_mark(bundle_t *bundle);

#endif
