#define _GNU_SOURCE
#include "requests.h"

#if defined _WIN32 || defined TICK_ONE_THREAD
int request_begin(worker_link *link, int32_t who, int64_t program, double time, double length, worker_link *const *links,
                  int64_t count)
{
    (void)link, (void)who, (void)program, (void)time, (void)length, (void)links, (void)count;
    return REQUEST_LEFT;
}

int request_finish(worker_link *link, int32_t who, int *interrupted)
{
    (void)link, (void)who, (void)interrupted;
    return REQUEST_LEFT;
}
#else
#include <errno.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

enum { PROGRAM, REQUEST, ANSWER, START };
enum { SAMPLE = 7, SLICE = 50 }; /* of so many messages one is timed; [ms] of a wait */

static double seconds(clockid_t clock)
{
    struct timespec at;
    clock_gettime(clock, &at);
    return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
}

int request_begin(worker_link *link, int32_t who, int64_t program, double time, double length, worker_link *const *links,
                  int64_t count)
{
    if (link->asking)
        return REQUEST_LEFT;
    link->reals[0] = time;
    link->reals[1] = length;
    link->busy_since = seconds(CLOCK_MONOTONIC);
    for (int64_t k = 0; k < count; k++)
        if (links[k]->timed)
            links[k]->overlap += SAMPLE * link->step;
    if (++link->messages % SAMPLE == 0) {
        link->timed = 1;
        link->since = seconds(CLOCK_THREAD_CPUTIME_ID);
    }
    link->numbers[PROGRAM] = program;
    link->numbers[START] = 0;
    link->by_c++;
    link->asking = who;
    __atomic_store_n(&link->numbers[REQUEST], ++link->number, __ATOMIC_RELEASE);
    return write(link->commands, "", 1) == 1 ? REQUEST_DONE : REQUEST_LEFT;
}

int request_finish(worker_link *link, int32_t who, int *interrupted)
{
    if (link->asking != who)
        return REQUEST_LEFT;
    if (link->timed) {
        link->timed = 0;
        link->overlap += SAMPLE * (seconds(CLOCK_THREAD_CPUTIME_ID) - link->since);
    }
    struct pollfd answer = {.fd = link->answers, .events = POLLIN};
    const int found = poll(&answer, 1, SLICE);
    if (found <= 0) {
        *interrupted = found < 0 && errno == EINTR;
        return found == 0 || *interrupted ? REQUEST_LASTS : REQUEST_LEFT;
    }
    char byte;
    if (__atomic_load_n(&link->numbers[ANSWER], __ATOMIC_ACQUIRE) != link->number || read(link->answers, &byte, 1) != 1)
        return REQUEST_LEFT;
    link->busy_since = 0.0;
    link->asking = 0;
    return REQUEST_DONE;
}
#endif
