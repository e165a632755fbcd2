/* Memory of one instance: blocks from the host's functions, released together. */
#ifndef FLEXSAT_MEMORY_H
#define FLEXSAT_MEMORY_H

#include <stddef.h>

typedef struct MemoryBlock MemoryBlock;

typedef struct Memory {
    void *(*allocate)(size_t count, size_t size); /* zeroed, as calloc */
    void (*release)(void *);
    MemoryBlock *last;
    int failed; /* an allocation has failed since the last release: what was returned then is NULL */
} Memory;

/* Zeroed, aligned for doubles; NULL and `failed` if there is none. */
void *memory_take(Memory *memory, size_t count, size_t size);
double *memory_doubles(Memory *memory, size_t count);

/* Release what was taken since `mark`, which was `last` then; NULL releases all of it. */
void memory_rewind(Memory *memory, MemoryBlock *mark);

/* Release all of it, and begin anew after a failure. */
void memory_release(Memory *memory);

#endif
