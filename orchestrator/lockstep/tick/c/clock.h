/* The clocks of the tick: stamps, which are cheap and count in a unit of their own, and deadlines in seconds. */
#ifndef LOCKSTEP_CLOCK_H
#define LOCKSTEP_CLOCK_H

#include <stdint.h>

#if defined(_WIN32)
#include <windows.h>
#else
#include <time.h>
#endif

/* The monotonic clock [s]. */
static inline double clock_now(void)
{
#if defined(_WIN32)
    LARGE_INTEGER count, rate;
    QueryPerformanceCounter(&count);
    QueryPerformanceFrequency(&rate);
    return (double)count.QuadPart / (double)rate.QuadPart;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#endif
}

/* Sleep until the clock reaches a time [s], or a little longer; a signal may end the sleep before. */
static inline void clock_sleep_until(double deadline)
{
#if defined(_WIN32)
    const double left = deadline - clock_now();
    if (left > 0.0)
        Sleep((DWORD)(1e3 * left));
#else
#if defined(__linux__)
    const double time = deadline;
#else
    const double left = deadline - clock_now(), time = left > 0.0 ? left : 0.0;
#endif
    struct timespec until;
    until.tv_sec = (time_t)time;
    until.tv_nsec = (long)(1e9 * (time - (double)until.tv_sec));
#if defined(__linux__)
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, 0);
#else
    nanosleep(&until, 0);
#endif
#endif
}

/* A count that grows evenly with time: of the processor where it has one that a program may read. */
static inline uint64_t clock_stamp(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    return __builtin_ia32_rdtsc();
#elif defined(__aarch64__) && defined(__GNUC__)
    uint64_t count;
    __asm__ volatile("mrs %0, cntvct_el0" : "=r"(count));
    return count;
#elif defined(_WIN32)
    LARGE_INTEGER count;
    QueryPerformanceCounter(&count);
    return (uint64_t)count.QuadPart;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
#endif
}

#endif
