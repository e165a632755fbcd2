/* What the C files use of Microsoft's string.h. */
#ifndef MICROSOFT_STRING_H
#define MICROSOFT_STRING_H

#include <stddef.h>

void *__cdecl memchr(const void *memory, int byte, size_t size);
int __cdecl memcmp(const void *one, const void *other, size_t size);
void *__cdecl memcpy(void *to, const void *from, size_t size);
void *__cdecl memmove(void *to, const void *from, size_t size);
void *__cdecl memset(void *memory, int byte, size_t size);
char *__cdecl strcat(char *text, const char *end);
char *__cdecl strchr(const char *text, int letter);
int __cdecl strcmp(const char *one, const char *other);
char *__cdecl strcpy(char *to, const char *from);
size_t __cdecl strlen(const char *text);
int __cdecl strncmp(const char *one, const char *other, size_t size);
char *__cdecl strncpy(char *to, const char *from, size_t size);
size_t __cdecl strspn(const char *text, const char *letters);

#endif
