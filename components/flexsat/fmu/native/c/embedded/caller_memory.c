/* memory.h with memory that the caller gives: one piece, of which blocks are taken one after the other. */
#include "caller_memory.h"

#include <stdint.h>
#include <string.h>

struct MemoryBlock {
    MemoryBlock *before;
    unsigned char *next, *end; /* what is free behind this block */
    double first;              /* what is taken begins here */
};

enum { HEAD = offsetof(MemoryBlock, first) };

int memory_given(Memory *memory, void *given, size_t size)
{
    MemoryBlock *base = given;

    memset(memory, 0, sizeof *memory);
    if (given == NULL || (uintptr_t)given % sizeof(double) != 0 || size < sizeof *base)
        return 1;
    base->before = NULL;
    base->next = (unsigned char *)&base->first;
    base->end = (unsigned char *)given + size;
    memory->last = base;
    return 0;
}

void *memory_take(Memory *memory, size_t count, size_t size)
{
    MemoryBlock *last = memory->last, *block = (MemoryBlock *)(void *)last->next;
    const size_t left = (size_t)(last->end - last->next), most = (size_t)-1 - HEAD - sizeof(double);
    size_t bytes;

    if (count == 0 || size == 0)
        count = size = 1; /* so that no place is NULL */
    if (count > most / size) {
        memory->failed = 1;
        return NULL;
    }
    bytes = HEAD + (count * size + sizeof(double) - 1) / sizeof(double) * sizeof(double);
    if (bytes > left) {
        memory->failed = 1;
        return NULL;
    }
    memset(block, 0, bytes);
    block->before = last;
    block->next = last->next + bytes;
    block->end = last->end;
    memory->last = block;
    return &block->first;
}

double *memory_doubles(Memory *memory, size_t count)
{
    return memory_take(memory, count, sizeof(double));
}

void memory_rewind(Memory *memory, MemoryBlock *mark)
{
    while (memory->last != mark && memory->last->before != NULL)
        memory->last = memory->last->before;
}

void memory_release(Memory *memory)
{
    memory_rewind(memory, NULL);
    memory->failed = 0;
}
