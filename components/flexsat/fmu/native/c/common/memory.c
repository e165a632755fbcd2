#include "memory.h"

struct MemoryBlock {
    MemoryBlock *before;
    double first; /* what is taken begins here, aligned as a double is */
};

void *memory_take(Memory *memory, size_t count, size_t size)
{
    const size_t head = offsetof(MemoryBlock, first);
    MemoryBlock *block = NULL;

    if (count == 0 || size == 0)
        count = size = 1; /* so that no place is NULL */
    if (count <= ((size_t)-1 - head - sizeof(MemoryBlock)) / size)
        block = memory->allocate(1, head + count * size + sizeof(double));
    if (block == NULL) {
        memory->failed = 1;
        return NULL;
    }
    block->before = memory->last;
    memory->last = block;
    return &block->first;
}

double *memory_doubles(Memory *memory, size_t count)
{
    return memory_take(memory, count, sizeof(double));
}

void memory_rewind(Memory *memory, MemoryBlock *mark)
{
    while (memory->last != mark && memory->last != NULL) {
        MemoryBlock *block = memory->last;
        memory->last = block->before;
        memory->release(block);
    }
}

void memory_release(Memory *memory)
{
    memory_rewind(memory, NULL);
    memory->failed = 0;
}
