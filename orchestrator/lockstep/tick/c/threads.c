#define _GNU_SOURCE
#include "threads.h"

#if defined _WIN32 || defined TICK_ONE_THREAD
#include <stddef.h>

thread_pool *pool_open(step_job *jobs, int32_t threads)
{
    (void)jobs, (void)threads;
    return NULL;
}

void pool_close(thread_pool *pool) { (void)pool; }

void job_begin(thread_pool *pool, step_job *job, double time)
{
    (void)pool;
    job->time = time;
    job->state = JOB_RUNNING;
    job->status = job->call(job->what, time);
    job->state = JOB_DONE;
}

int32_t job_finish(thread_pool *pool, step_job *job, double patience)
{
    (void)pool, (void)job, (void)patience;
    return 1;
}
#else
#include <pthread.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <time.h>

enum { MEASURED_EVERY = 16, SPINS = 2000 };

static double now(void)
{
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
}

/* Make a step in the calling thread; measure every sixteenth, as the clock takes longer than a small step. */
static void make(step_job *job)
{
    if (job->begun++ % MEASURED_EVERY) {
        job->status = job->call(job->what, job->time);
        return;
    }
    double start = now();
    job->status = job->call(job->what, job->time);
    job->busy += now() - start;
    job->measured++;
}

enum { STACK = 8 << 20 }; /* bytes of a thread's stack: what a main thread has on Linux, and some FMUs rely on */

struct thread_pool {
    step_job *jobs;
    pthread_mutex_t lock;
    pthread_cond_t work, done;
    int64_t first, last; /* of the jobs that wait, or -1 */
    int32_t waiting;     /* how many those are; read without the lock while a thread spins */
    int32_t sleeping;    /* threads that wait for work and do not spin */
    int32_t master_sleeps, closing, threads;
    pthread_t thread[];
};

static void relax(void)
{
#if defined __x86_64__ || defined __i386__
    __builtin_ia32_pause();
#elif defined __aarch64__
    __asm__ volatile("yield");
#endif
}

static int32_t read_now(const int32_t *value) { return __atomic_load_n(value, __ATOMIC_ACQUIRE); }

static void write_now(int32_t *value, int32_t content) { __atomic_store_n(value, content, __ATOMIC_RELEASE); }

/* Take the first job that waits. With the lock. */
static step_job *take_first(thread_pool *pool)
{
    step_job *job = &pool->jobs[pool->first];
    pool->first = job->next;
    if (pool->first < 0) pool->last = -1;
    write_now(&pool->waiting, pool->waiting - 1);
    write_now(&job->state, JOB_RUNNING);
    return job;
}

/* Take this job, which waits. With the lock. */
static void take(thread_pool *pool, step_job *job)
{
    int64_t number = job - pool->jobs, before = -1;
    for (int64_t k = pool->first; k != number; k = pool->jobs[k].next) before = k;
    if (before < 0) pool->first = job->next;
    else pool->jobs[before].next = job->next;
    if (pool->last == number) pool->last = before;
    write_now(&pool->waiting, pool->waiting - 1);
    write_now(&job->state, JOB_RUNNING);
}

static void *serve(void *argument)
{
    thread_pool *pool = argument;
    pthread_mutex_lock(&pool->lock);
    while (!pool->closing) {
        if (pool->first < 0) {
            pthread_mutex_unlock(&pool->lock);
            for (int k = 0; k < SPINS && !read_now(&pool->waiting) && !read_now(&pool->closing); k++) relax();
            pthread_mutex_lock(&pool->lock);
        }
        if (pool->closing) break;
        if (pool->first < 0) {
            pool->sleeping++;
            pthread_cond_wait(&pool->work, &pool->lock);
            pool->sleeping--;
            continue;
        }
        step_job *job = take_first(pool);
        pthread_mutex_unlock(&pool->lock);
        make(job);
        pthread_mutex_lock(&pool->lock);
        write_now(&job->state, JOB_DONE);
        if (pool->master_sleeps) pthread_cond_signal(&pool->done);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* Start a thread with the floating-point settings of this one, which it inherits, and without signals for others. */
static int start(thread_pool *pool, pthread_t *thread)
{
    pthread_attr_t attributes;
    sigset_t blocked, before;
    if (pthread_attr_init(&attributes)) return 1;
    int failed = pthread_attr_setstacksize(&attributes, STACK);
    sigfillset(&blocked);
    int of_a_step[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS};
    for (size_t k = 0; k < sizeof of_a_step / sizeof *of_a_step; k++) sigdelset(&blocked, of_a_step[k]);
    pthread_sigmask(SIG_SETMASK, &blocked, &before);
    failed = failed || pthread_create(thread, &attributes, serve, pool);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&attributes);
    return failed;
}

thread_pool *pool_open(step_job *jobs, int32_t threads)
{
    thread_pool *pool = calloc(1, sizeof *pool + (size_t)threads * sizeof(pthread_t));
    if (!pool) return NULL;
    pool->jobs = jobs;
    pool->first = pool->last = -1;
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
#if !defined __APPLE__
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
#endif
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->done, &attributes);
    pthread_condattr_destroy(&attributes);
    while (pool->threads < threads && !start(pool, &pool->thread[pool->threads])) pool->threads++;
    if (pool->threads == threads) return pool;
    pool_close(pool);
    return NULL;
}

void pool_close(thread_pool *pool)
{
    if (!pool) return;
    pthread_mutex_lock(&pool->lock);
    write_now(&pool->closing, 1);
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    for (int32_t k = 0; k < pool->threads; k++) pthread_join(pool->thread[k], NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->lock);
    free(pool);
}

void job_begin(thread_pool *pool, step_job *job, double time)
{
    job->time = time;
    if (!pool || !job->apart) {
        write_now(&job->state, JOB_RUNNING);
        make(job);
        write_now(&job->state, JOB_DONE);
        return;
    }
    int64_t number = job - pool->jobs;
    pthread_mutex_lock(&pool->lock);
    job->next = -1;
    write_now(&job->state, JOB_WAITING);
    if (pool->last < 0) pool->first = number;
    else pool->jobs[pool->last].next = number;
    pool->last = number;
    write_now(&pool->waiting, pool->waiting + 1);
    if (pool->sleeping) pthread_cond_signal(&pool->work);
    pthread_mutex_unlock(&pool->lock);
}

/* Wait without making steps: 1 when the job is done, 0 when so many seconds have passed. */
static int32_t wait_for(thread_pool *pool, step_job *job, double patience)
{
    for (int k = 0; k < SPINS; k++) {
        if (read_now(&job->state) == JOB_DONE) return 1;
        relax();
    }
    struct timespec end;
#if defined __APPLE__
    end.tv_sec = (time_t)patience;
    end.tv_nsec = (long)(1e9 * (patience - (double)end.tv_sec));
#else
    double due = now() + patience;
    end.tv_sec = (time_t)due;
    end.tv_nsec = (long)(1e9 * (due - (double)end.tv_sec));
#endif
    int late = 0;
    pthread_mutex_lock(&pool->lock);
    pool->master_sleeps = 1;
    while (job->state != JOB_DONE && !late) {
#if defined __APPLE__
        late = pthread_cond_timedwait_relative_np(&pool->done, &pool->lock, &end);
#else
        late = pthread_cond_timedwait(&pool->done, &pool->lock, &end);
#endif
    }
    pool->master_sleeps = 0;
    int32_t done = job->state == JOB_DONE;
    pthread_mutex_unlock(&pool->lock);
    return done;
}

int32_t job_finish(thread_pool *pool, step_job *job, double patience)
{
    int32_t state = read_now(&job->state);
    while (state == JOB_WAITING || state == JOB_RUNNING) {
        step_job *own = NULL;
        pthread_mutex_lock(&pool->lock);
        if (job->state == JOB_WAITING) take(pool, own = job);
        else if (job->state == JOB_RUNNING && pool->first >= 0) own = take_first(pool);
        pthread_mutex_unlock(&pool->lock);
        if (own) {
            make(own);
            write_now(&own->state, JOB_DONE);
        } else if (!wait_for(pool, job, patience)) return 0;
        state = read_now(&job->state);
    }
    return 1;
}
#endif
