/* What a library for Windows needs besides the Universal C Runtime where Zig links it without the static library of
MinGW-w64, which Zig would have to build first: an entry, and functions that the compiler and the headers expect there. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define WHOLE_LENGTH 2u /* return the length that the whole text has, as C99 wants */

__declspec(dllimport) int __stdio_common_vsprintf(unsigned long long options, char *text, size_t size, const char *format,
                                                  _locale_t locale, va_list arguments);

int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved)
{
    (void)library, (void)reason, (void)reserved;
    return 1;
}

int vsnprintf(char *text, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(WHOLE_LENGTH, text, size, format, NULL, arguments);
}

int snprintf(char *text, size_t size, const char *format, ...)
{
    va_list arguments;
    int length;

    va_start(arguments, format);
    length = vsnprintf(text, size, format, arguments);
    va_end(arguments);
    return length;
}
