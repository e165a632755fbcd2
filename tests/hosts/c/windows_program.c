/* What a program for Windows needs besides the Universal C Runtime where Zig links it without the static library of
MinGW-w64, which it would have to build first: an entry, and the functions that its headers expect there. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

void __main(void);
int main(int argument_count, char **arguments);

__declspec(dllimport) int _configure_narrow_argv(int mode);
__declspec(dllimport) int *__p___argc(void);
__declspec(dllimport) char ***__p___argv(void);

void __main(void) {} /* called at the beginning of main: there is nothing to prepare */

int mainCRTStartup(void) {
    _configure_narrow_argv(1); /* as they are, without wildcards */
    exit(main(*__p___argc(), *__p___argv()));
}

int vfprintf(FILE *file, const char *format, va_list arguments) {
    return __stdio_common_vfprintf(0, file, format, NULL, arguments);
}

int fprintf(FILE *file, const char *format, ...) {
    va_list arguments;
    int length;
    va_start(arguments, format);
    length = vfprintf(file, format, arguments);
    va_end(arguments);
    return length;
}

int printf(const char *format, ...) {
    va_list arguments;
    int length;
    va_start(arguments, format);
    length = vfprintf(stdout, format, arguments);
    va_end(arguments);
    return length;
}

int fscanf(FILE *file, const char *format, ...) {
    va_list arguments;
    int count;
    va_start(arguments, format);
    count = __stdio_common_vfscanf(0, file, format, NULL, arguments);
    va_end(arguments);
    return count;
}
