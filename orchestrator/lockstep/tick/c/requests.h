/* Steps of FMUs in worker processes: a request is a number in shared memory and a byte that wakes the worker, and so is
its answer. What is not the usual answer is left to the caller, which can see why. */
#ifndef LOCKSTEP_REQUESTS_H
#define LOCKSTEP_REQUESTS_H

#include <stdint.h>

/* See lockstep/processes/worker_link.py. */
typedef struct {
    int64_t *numbers; /* program, request, answer, start */
    double *reals;    /* time and step */
    int64_t number, by_c;
    double busy_since;
    int64_t messages;
    double since, overlap, step;
    int32_t commands, answers, asking, timed;
} worker_link;

enum { REQUEST_DONE, REQUEST_LEFT, REQUEST_LASTS };

/* Make the request `who` (above 0) to run a program. REQUEST_LEFT: another one is under way, or the pipe is closed.

`links` are those of all workers: while some are timed, their overlaps grow by what this worker has to do. */
int request_begin(worker_link *link, int32_t who, int64_t program, double time, double length, worker_link *const *links,
                  int64_t count);

/* Wait for the usual answer to a request. REQUEST_LEFT: it is another one. REQUEST_LASTS: none for 0.05 s, or a signal. */
int request_finish(worker_link *link, int32_t who, int *interrupted);

#endif
