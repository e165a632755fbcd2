/* Waiting for real time: the operation TICK_PACE.
 *
 * Its buffer holds the numbers below, which the caller sets and reads; `first` the `count` edges [s] of the histogram,
 * ascending, and `marks` its count + 1 numbers of type int64_t.
 */
#ifndef LOCKSTEP_PACE_H
#define LOCKSTEP_PACE_H

#include "clock.h"
#include "tick.h"

enum pace_number {
    PACE_ORIGIN,   /* when `first` is due, on the monotonic clock [s] */
    PACE_FIRST,    /* simulated time [s] */
    PACE_FACTOR,   /* of real time */
    PACE_POLLING,  /* before a deadline the clock is polled [s] */
    PACE_OVERRUNS, /* ticks whose work was not done when the next one was due */
    PACE_WORST,    /* by which one ended late at most [s] */
    PACE_WORST_AT  /* simulated start of the tick after it [s] */
};

#define PACE_SLICE 0.02 /* [s] of sleep at most between two looks at `look` */

/* Wait until a simulated time is due, or count an overrun; return 0, to be called again, if `look` was set. */
static inline int pace_wait(const tick_operation *op, double time, const volatile int32_t *look)
{
    double *const numbers = op->buffer;
    int64_t *const counts = (int64_t *)(void *)op->marks;
    const double due = numbers[PACE_ORIGIN] + (time - numbers[PACE_FIRST]) / numbers[PACE_FACTOR];
    double now = clock_now();
    if (now > due) {
        if (time > numbers[PACE_FIRST]) {
            numbers[PACE_OVERRUNS] += 1.0;
            if (now - due > numbers[PACE_WORST]) {
                numbers[PACE_WORST] = now - due;
                numbers[PACE_WORST_AT] = time;
            }
        }
    } else {
        while (due - now > numbers[PACE_POLLING]) {
            const double wake = due - numbers[PACE_POLLING];
            if (*look)
                return 0;
            clock_sleep_until(wake - now < PACE_SLICE ? wake : now + PACE_SLICE);
            now = clock_now();
        }
        while (now < due)
            now = clock_now();
    }
    size_t bin = 0;
    while (bin < op->count && op->first[bin] <= now - due)
        bin++;
    counts[bin]++;
    return 1;
}

#endif
