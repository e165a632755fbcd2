/* A tick of a co-simulation as a flat table of operations: gather, convert, set, step, get, check, record.
 *
 * `tick_run` executes ticks until it needs its caller: it never calls back. It returns why, with the place in `state`,
 * and goes on from there when it is called again. All memory belongs to the caller and must not move while a state
 * refers to it. Nothing here knows Python; a caller in C has to handle the same reasons.
 */
#ifndef LOCKSTEP_TICK_H
#define LOCKSTEP_TICK_H

#include <stddef.h>
#include <stdint.h>

#include "requests.h"
#include "threads.h"

#define TICK_LAYOUT 8 /* of the structures and functions below; grows with each change */

/* What an operation does. The fields of `tick_operation` that it uses are named behind it. */
enum tick_kind {
    TICK_CALLER,   /* returns TICK_CALLER_ACTS in ticks from `from` to `until` (exclusive); else nothing */
    TICK_GATHER_4, /* buffer[k] = source[index[k]], values of 4 bytes; count */
    TICK_GATHER_8, /* the same, of 8 bytes */
    TICK_SCATTER_4, /* buffer[index[k]] = source[k], values of 4 bytes; count */
    TICK_SCATTER_8, /* the same, of 8 bytes */
    TICK_CONVERT,  /* buffer[k] = buffer[k] * first[k] + second[k], rounded twice; TICK_NOT_FINITE if one is; count */
    TICK_FINITE,   /* TICK_NOT_FINITE if buffer[k] is not finite and not marks[k]; count */
    TICK_VALUES,   /* fmiGet/fmiSet of FMI 1.0, 2.0: function, instance, references, count, buffer */
    TICK_ARRAYS,   /* fmi3Get/fmi3Set: and `values` in the buffer */
    TICK_STEP_1,   /* fmiDoStep of `length` seconds: function, instance */
    TICK_STEP_2,   /* fmi2DoStep */
    TICK_STEP_3,   /* fmi3DoStep: its flags to marks (3 bytes), its last time to buffer (double); with a flag that is
                      set the status becomes 2, fmi3Discard */
    TICK_ROW,      /* begins a row of the recorder at the present time; TICK_ROWS_FULL if there is no room */
    TICK_RECORD_REALS,    /* the row's column[k] = source[index[k]]; count, part */
    TICK_RECORD_INTEGERS, /* the same from int32_t to double */
    TICK_RECORD_WIDE,     /* the same of 8 bytes unchanged */
    /* Faults, which alter buffer[index[k]] in ticks from `from` to `until` (exclusive); count */
    TICK_ADD,      /* adds first[k] */
    TICK_MULTIPLY, /* multiplies by first[k] */
    TICK_HOLD_4,   /* holds the last values before the window, or the first ever, of 4 bytes: memory, history */
    TICK_HOLD_8,   /* the same of 8 bytes */
    TICK_DELAY_4,  /* gives the values of so many ticks ago, of 4 bytes: memory, history */
    TICK_DELAY_8,  /* the same of 8 bytes */
    /* Booleans of one byte */
    TICK_WIDEN, /* int32_t buffer[k] = byte source[index[k]]; count */
    TICK_NARROW, /* byte buffer[index[k]] = int32_t source[k] != 0; count */
    /* Steps in threads */
    TICK_BEGIN,  /* begins a step of kind `values`, with the fields of that; part: the number of the job */
    TICK_FINISH, /* completes it: TICK_CALLER_ACTS if its status is above 0 or it logged anything; part */
    TICK_PACE,   /* waits until the present time is due: see pace.h; buffer, first, marks, count */
    /* Steps in worker processes: TICK_CALLER_ACTS where C leaves it to the caller */
    TICK_REQUEST, /* requests a step of `length` by program `count` of the worker_link at instance; part: its number */
    TICK_ANSWER,  /* waits for its answer: instance, part */
    /* Neighbouring values, of which no index is needed */
    TICK_COPY,       /* buffer = source, count bytes */
    TICK_RECORD_COPY /* the row's columns from `values` on = source, values of 8 bytes; count, part */
};

/* Why `tick_run` returned. */
enum tick_reason {
    TICK_DONE,        /* `tick` is `until` */
    TICK_CALLER_ACTS, /* the operation at `position` is the caller's: do it, then continue behind it */
    TICK_STATUS,      /* a call returned `status` above 0 (OK): judge it, then continue behind it */
    TICK_NOT_FINITE,  /* a value is not finite: judge it, then continue behind it */
    TICK_ROWS_FULL,   /* write the rows and set rows.count to 0, then continue at the same operation */
    TICK_LOOK,        /* `look` was set: set it to 0, then continue at the same operation */
    TICK_AT_LAST      /* by tick_step: all ticks that it may execute are complete */
};

typedef void (*tick_function)(void); /* of FMI; called with its own type, which `kind` names */

typedef struct tick_operation {
    uint32_t kind;
    uint32_t part; /* of a row: number of the type, see tick_rows */
    uint32_t account; /* of the wall time it takes, see tick_state */
    tick_function function;
    void *instance;
    const uint32_t *references;
    size_t count;
    size_t values; /* of FMI 3.0 */
    void *buffer;
    const void *source;
    const int64_t *index;
    const double *first, *second;
    unsigned char *marks;
    double length; /* [s] of a step */
    int64_t from, until;
    void *memory;     /* of a fault: values held, or those of a ring of transfers */
    int64_t *history; /* of a hold: {0: none, 1: held, 2: given}; of a delay: {oldest, number, room, delay, ticks ...} */
} tick_operation;

#define TICK_PARTS 5 /* Reals, Integers, Booleans, Int64s, UInt64s */

/* The recorder's block of rows. The first three parts are doubles, the others integers of 8 bytes. */
typedef struct tick_rows {
    double *times;
    void *parts[TICK_PARTS];    /* first element of the first row */
    size_t strides[TICK_PARTS]; /* elements from a row to the next */
    size_t count, size;         /* rows there are, and fit */
} tick_rows;

typedef struct tick_state {
    /* the program: tick t executes operations[order[k]] for k from begins[t % cycle] to ends[t % cycle] (exclusive) */
    const tick_operation *operations;
    const uint32_t *order;
    const uint64_t *begins, *ends;
    uint64_t cycle;
    /* time in seconds is (origin + tick * length) / second, all of them whole and below 2^53 */
    int64_t origin, length;
    double second;
    /* where it is */
    int64_t tick, until; /* the present tick, and the first that is not executed */
    uint64_t position;   /* in order; counts while `begun` */
    int32_t begun;       /* whether the present tick has begun */
    uint32_t status;     /* of the call at which it stopped */
    double time;         /* [s] at which the present tick began */
    volatile int32_t look; /* set by another thread to have TICK_LOOK returned soon */
    tick_rows rows;
    thread_pool *pool; /* NULL: without threads */
    step_job *jobs;
    /* where the wall time goes, in stamps of the clock; nothing is measured where `spent` is null */
    uint64_t *spent; /* by account; 0 is that of what is no operation */
    uint64_t stamp;  /* when the present account began; 0: what passed before the call is nobody's */
    uint32_t account;
    worker_link **links; /* of all workers of requests */
    int64_t link_count;
} tick_state;

/* Execute ticks; return a tick_reason. To continue behind the operation at `position`, add 1 to it before. */
TICK_EXPORT int tick_run(tick_state *state);

/* Execute one tick unless `last` of them are complete. After another reason than these two, continue by tick_run. */
TICK_EXPORT int tick_step(tick_state *state, int64_t last);

/* The present stamp of the clock: see `spent`. */
TICK_EXPORT uint64_t tick_stamp(void);

/* TICK_LAYOUT, and the sizes of an operation and of a state: what a caller compares with its own. */
TICK_EXPORT void tick_layout(size_t sizes[3]);

#endif
