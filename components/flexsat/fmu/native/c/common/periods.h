/* Periods as whole numbers of steps: the twin of runtime/periods.py. */
#ifndef FLEXSAT_PERIODS_H
#define FLEXSAT_PERIODS_H

#include <stdint.h>

/* period / step as a whole number from 1; 0 if it is none. Decimal periods are not exact in binary: a difference of a
millionth of a step is accepted. */
int64_t whole_multiple(double period, double step);

#endif
