#include "wide_registers.h"

#ifdef FOUR_IN_REGISTERS
#include <cpuid.h>

/* Not __builtin_cpu_supports, which needs a library of the compiler. */
int has_wide_registers(void)
{
    const unsigned int both = bit_OSXSAVE | bit_AVX, saved = 6; /* of registers of two, and of four doubles */
    unsigned int a, b, c, d;

    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & both) != both)
        return 0;
    __asm__ volatile("xgetbv" : "=a"(a), "=d"(d) : "c"(0));
    if ((a & saved) != saved)
        return 0;
    return __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2) != 0;
}
#else
int has_wide_registers(void) { return 0; }
#endif
