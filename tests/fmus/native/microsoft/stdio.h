/* What the C files use of Microsoft's stdio.h. */
#ifndef MICROSOFT_STDIO_H
#define MICROSOFT_STDIO_H

#include <stdarg.h>
#include <stddef.h>

typedef struct _iobuf FILE;

FILE *__cdecl __acrt_iob_func(unsigned index);
#define stdout (__acrt_iob_func(1))
#define stderr (__acrt_iob_func(2))

int __cdecl fprintf(FILE *file, const char *format, ...);
int __cdecl fputs(const char *text, FILE *file);
int __cdecl printf(const char *format, ...);
int __cdecl snprintf(char *text, size_t size, const char *format, ...);
int __cdecl sprintf(char *text, const char *format, ...);
int __cdecl vsnprintf(char *text, size_t size, const char *format, va_list arguments);

#endif
