/* What the C files use of Microsoft's stdlib.h. */
#ifndef MICROSOFT_STDLIB_H
#define MICROSOFT_STDLIB_H

#include <stddef.h>

int __cdecl abs(int x);
int __cdecl atoi(const char *text);
void *__cdecl calloc(size_t count, size_t size);
void __cdecl free(void *memory);
void *__cdecl malloc(size_t size);
double __cdecl strtod(const char *text, char **end);

#endif
