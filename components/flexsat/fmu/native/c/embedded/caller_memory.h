/* Memory of one controller, from the caller. */
#ifndef FLEXSAT_CALLER_MEMORY_H
#define FLEXSAT_CALLER_MEMORY_H

#include "memory.h"

/* Take blocks from this piece of memory from now on; returns 0, or 1 if it is NULL, too small or not aligned. */
int memory_given(Memory *memory, void *given, size_t size);

#endif
