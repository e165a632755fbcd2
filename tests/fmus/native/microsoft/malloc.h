/* What the compiler's own emmintrin.h needs of Microsoft's malloc.h. */
#ifndef MICROSOFT_MALLOC_H
#define MICROSOFT_MALLOC_H

#include <stddef.h>

void *__cdecl _aligned_malloc(size_t size, size_t alignment);
void __cdecl _aligned_free(void *memory);

#endif
