/* Steps of FMUs in threads beside that of the master: a step is begun, and finished before its results are used.

A step that no thread has started when it is to be finished is made by the master itself, and so are other steps that
wait while it waits: no core of those in use is idle while there is a step to make. Steps of one instance never overlap.
*/
#ifndef LOCKSTEP_THREADS_H
#define LOCKSTEP_THREADS_H

#include <stdint.h>

#if defined(TICK_EXPORT) /* by the command line: a library that has the tick inside exports nothing of it */
#elif defined(_WIN32)
#define TICK_EXPORT __declspec(dllexport)
#else
#define TICK_EXPORT __attribute__((visibility("default")))
#endif

typedef int32_t (*job_call)(const void *what, double time); /* returns the status of FMI */

/* One component's step. Python reads and writes it while no step is under way, and `logged` at any time. */
typedef struct {
    job_call call;
    const void *what;
    double time;    /* of the step under way, at its start [s] */
    double busy;    /* wall time of the steps that were measured [s] */
    int64_t measured; /* how many those are */
    int64_t begun;  /* how many steps were begun */
    int32_t apart;  /* whether threads may make the step; else `job_begin` makes it */
    int32_t status; /* that the last step returned */
    int32_t state;  /* JOB_...; other threads than that of the step read and write it under the lock of the pool */
    int32_t logged; /* whether messages of the step are kept until it is finished */
    int64_t next;   /* the number of the job that waits behind this one, or -1 */
} step_job;

enum { JOB_NONE, JOB_WAITING, JOB_RUNNING, JOB_DONE };

typedef struct thread_pool thread_pool;

/* Start so many threads for jobs, an array that must not move. Returns NULL where the system refuses one. */
TICK_EXPORT thread_pool *pool_open(step_job *jobs, int32_t threads);

/* End the threads, when no job is under way. */
TICK_EXPORT void pool_close(thread_pool *pool);

/* Begin a step. Without a pool, or where the job is not `apart`, the caller makes it. */
TICK_EXPORT void job_begin(thread_pool *pool, step_job *job, double time);

/* Complete a step: returns 1, or 0 if it still lasts after so many seconds. May be called again, and without a step. */
TICK_EXPORT int32_t job_finish(thread_pool *pool, step_job *job, double patience);

#endif
