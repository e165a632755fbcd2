/* What a library for Windows needs besides the Universal C Runtime where Zig links it: an entry, and the functions that
the compiler, and the headers of MinGW-w64, expect in its static library. That library would take Zig minutes to build on each machine, and
has another exp() and sin() than Windows. Microsoft's compiler needs none of this; it does not travel in FMUs. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define STANDARD_LENGTH 2u /* return the length that the whole text has, as C99 wants */

/* The Universal C Runtime's printf of all kinds. */
__declspec(dllimport) int __stdio_common_vsprintf(uint64_t options, char *text, size_t size, const char *format,
                                                  void *locale, va_list arguments);

int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved)
{
    (void)library;
    (void)reason;
    (void)reserved;
    return 1; /* there is nothing to prepare */
}

/* Called by functions with more than a page of local variables, whose size is in rax: Windows adds pages to a stack one
by one, so that each has to be touched in turn. All registers keep their values. */
__asm__(".globl ___chkstk_ms\n"
        "___chkstk_ms:\n"
        "    pushq %rcx\n"
        "    pushq %rax\n"
        "    movq %rsp, %rcx\n"
        "1:  cmpq $4096, %rax\n"
        "    jbe 2f\n"
        "    subq $4096, %rcx\n"
        "    subq $4096, %rax\n"
        "    orl $0, (%rcx)\n"
        "    jmp 1b\n"
        "2:  subq %rax, %rcx\n"
        "    orl $0, (%rcx)\n"
        "    popq %rax\n"
        "    popq %rcx\n"
        "    ret\n");

int vsnprintf(char *text, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(STANDARD_LENGTH, text, size, format, NULL, arguments);
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

int sprintf(char *text, const char *format, ...)
{
    va_list arguments;
    int length;

    va_start(arguments, format);
    length = vsnprintf(text, (size_t)-1 >> 1, format, arguments);
    va_end(arguments);
    return length;
}

/* Behind isfinite() and its like: the values of FP_NAN, FP_NORMAL, FP_ZERO and FP_SUBNORMAL in math.h of MinGW-w64. */
int __fpclassify(double value)
{
    uint64_t bits;
    unsigned int exponent;

    memcpy(&bits, &value, sizeof bits);
    exponent = (unsigned int)(bits >> 52) & 0x7ffu;
    bits &= UINT64_C(0x000fffffffffffff);
    if (exponent == 0x7ffu)
        return bits == 0 ? 0x0500 : 0x0100;
    if (exponent != 0)
        return 0x0400;
    return bits == 0 ? 0x4000 : 0x4400;
}
