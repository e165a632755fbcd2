#include "memory.h"

#include <stdlib.h>
#include <string.h>

typedef union block {
    union block *next;
    double alignment[2];
} block_t;

const size_t sizes[ALL_TYPES] = {sizeof(fmi2Real), sizeof(fmi2Integer), sizeof(fmi2Boolean), sizeof(fmi2String)};

void *keep(bundle_t *bundle, size_t count, size_t size)
{
    block_t *block = count > (SIZE_MAX / 2) / size ? NULL : calloc(1, sizeof *block + count * size);

    if (block == NULL)
        return NULL;
    block->next = bundle->blocks;
    bundle->blocks = block;
    return block + 1;
}

void free_kept(bundle_t *bundle)
{
    block_t *block = bundle->blocks;

    while (block != NULL) {
        block_t *next = block->next;
        free(block);
        block = next;
    }
    bundle->blocks = NULL;
}

char *copy_text(const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = malloc(size);

    if (copy != NULL)
        memcpy(copy, text, size);
    return copy;
}

void *grown(room_t *room, size_t size)
{
    if (size > room->size) {
        void *memory = realloc(room->memory, size);
        if (memory == NULL)
            return NULL;
        room->memory = memory;
        room->size = size;
    }
    return room->memory;
}

double time_of(const bundle_t *bundle, int64_t tick)
{
    return (double)(bundle->state.origin + tick * bundle->state.length) / bundle->state.second;
}

double time_now(const bundle_t *bundle)
{
    return time_of(bundle, bundle->state.tick);
}
