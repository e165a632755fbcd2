/* Registers of four doubles (AVX2), which not every x86-64 has: functions that use them are compiled beside others, and
chosen when a model is prepared. They must round as the others do, so that results are the same on every processor: no
fused operations, and sums in the same order. */
#ifndef FLEXSAT_WIDE_REGISTERS_H
#define FLEXSAT_WIDE_REGISTERS_H

#if defined(__GNUC__) && defined(__x86_64__) && defined(__SSE2__)
#define FOUR_IN_REGISTERS
#define IN_WIDE_REGISTERS __attribute__((target("avx2")))
#endif

/* Whether this processor has them, and its operating system saves them. */
int has_wide_registers(void);

#endif
