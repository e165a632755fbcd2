/* The loop of ticks: see tick.h. Compile without fused multiplication and addition: results are those of two. */
#if !defined(_POSIX_C_SOURCE) && !defined(_WIN32)
#define _POSIX_C_SOURCE 200112L
#endif
#include "tick.h"

#include "alter.h"
#include "clock.h"
#include "pace.h"

#include <string.h>

typedef unsigned (*values_function)(void *, const uint32_t *, size_t, void *);
typedef unsigned (*arrays_function)(void *, const uint32_t *, size_t, void *, size_t);
typedef unsigned (*step_1_function)(void *, double, double, char);
typedef unsigned (*step_2_function)(void *, double, double, int);
typedef unsigned (*step_3_function)(void *, double, double, _Bool, unsigned char *, unsigned char *, unsigned char *,
                                    double *);

enum { WARNING = 1, DISCARD = 2 };

static const double PATIENCE = 0.05; /* [s] of a wait for a step, after which `look` is read */

static int is_finite(double value)
{
    const uint64_t exponent = 0x7ff0000000000000u;
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (bits & exponent) != exponent;
}

static int convert(const tick_operation *op)
{
    double *values = op->buffer;
    int finite = 1;
    for (size_t k = 0; k < op->count; k++) {
        const double scaled = values[k] * op->first[k];
        values[k] = scaled + op->second[k];
        finite &= is_finite(values[k]);
    }
    return finite;
}

static int all_finite(const tick_operation *op)
{
    const double *values = op->buffer;
    double sums[8] = {0.0}; /* so many run at once, as none waits for the others */
    size_t done = 0;
    int finite = 1;
    for (; done + 8 <= op->count; done += 8)
        for (size_t i = 0; i < 8; i++)
            sums[i] += values[done + i];
    for (size_t i = 0; i < 8; i++)
        finite &= is_finite(sums[i]); /* not finite if one of its values is not, or only the sum */
    for (; done < op->count; done++)
        finite &= is_finite(values[done]);
    for (size_t k = 0; !finite && k < op->count; k++)
        if (!is_finite(values[k]) && !op->marks[k])
            return 0;
    return 1;
}

/* Values of any type are moved as bytes: they are written as one type and read as another. */
static void gather_4(const tick_operation *op)
{
    const char *source = op->source;
    char *buffer = op->buffer;
    for (size_t k = 0; k < op->count; k++)
        memcpy(buffer + 4 * k, source + 4 * op->index[k], 4);
}

static void gather_8(const tick_operation *op, char *buffer)
{
    const char *source = op->source;
    for (size_t k = 0; k < op->count; k++)
        memcpy(buffer + 8 * k, source + 8 * op->index[k], 8);
}

static void scatter_4(const tick_operation *op)
{
    const char *source = op->source;
    char *buffer = op->buffer;
    for (size_t k = 0; k < op->count; k++)
        memcpy(buffer + 4 * op->index[k], source + 4 * k, 4);
}

static void scatter_8(const tick_operation *op)
{
    const char *source = op->source;
    char *buffer = op->buffer;
    for (size_t k = 0; k < op->count; k++)
        memcpy(buffer + 8 * op->index[k], source + 8 * k, 8);
}

static void widen(const tick_operation *op)
{
    const unsigned char *source = op->source;
    int32_t *buffer = op->buffer;
    for (size_t k = 0; k < op->count; k++)
        buffer[k] = source[op->index[k]];
}

static void narrow(const tick_operation *op)
{
    const int32_t *source = op->source;
    unsigned char *buffer = op->buffer;
    for (size_t k = 0; k < op->count; k++)
        buffer[op->index[k]] = source[k] != 0;
}

static void integers_as_reals(const tick_operation *op, double *row)
{
    const int32_t *source = op->source;
    for (size_t k = 0; k < op->count; k++)
        row[k] = source[op->index[k]];
}

/* Where the part of an operation begins in the newest row, whose elements have 8 bytes. */
static void *row_of(const tick_operation *op, const tick_rows *rows)
{
    return (char *)rows->parts[op->part] + 8 * (rows->count - 1) * rows->strides[op->part];
}

static unsigned step_3(const tick_operation *op, double time)
{
    unsigned char *flags = op->marks; /* event handling needed, terminate simulation, early return */
    const unsigned status = ((step_3_function)op->function)(op->instance, time, op->length, 1, flags, flags + 1,
                                                            flags + 2, op->buffer);
    return status <= WARNING && (flags[0] | flags[1] | flags[2]) ? DISCARD : status;
}

static unsigned step(const tick_operation *op, uint32_t kind, double time)
{
    if (kind == TICK_STEP_1)
        return ((step_1_function)op->function)(op->instance, time, op->length, 1);
    if (kind == TICK_STEP_2)
        return ((step_2_function)op->function)(op->instance, time, op->length, 1);
    return step_3(op, time);
}

static int32_t step_of_job(const void *operation, double time)
{
    const tick_operation *op = operation;
    return (int32_t)step(op, (uint32_t)op->values, time);
}

static void begin(const tick_operation *op, const tick_state *state)
{
    step_job *job = state->jobs + op->part;
    job->call = step_of_job;
    job->what = op;
    job_begin(state->pool, job, state->time);
}

/* Wait for the answer of a worker. */
static int answer(const tick_operation *op, const tick_state *state)
{
    for (;;) {
        int interrupted = 0;
        switch (request_finish(op->instance, (int32_t)op->part + 1, &interrupted)) {
        case REQUEST_DONE: return TICK_DONE;
        case REQUEST_LEFT: return TICK_CALLER_ACTS;
        }
        if (interrupted || state->look)
            return TICK_LOOK;
    }
}

static int takes_long(uint32_t kind)
{
    return kind == TICK_CALLER || kind == TICK_PACE || kind == TICK_BEGIN || kind == TICK_REQUEST ||
           (kind >= TICK_STEP_1 && kind <= TICK_STEP_3);
}

/* Charge the time since the last stamp to the present account, and begin another one. */
static void begin_account(tick_state *state, uint32_t account)
{
    const uint64_t now = clock_stamp();
    if (state->stamp)
        state->spent[state->account] += now - state->stamp;
    state->stamp = now;
    state->account = account;
}

/* Execute the operations of the present tick from `position` on; return TICK_DONE after the last. */
static int run_tick(tick_state *state)
{
    const tick_operation *const operations = state->operations;
    const uint32_t *const order = state->order;
    const uint64_t end = state->ends[(uint64_t)state->tick % state->cycle];
    const double time = state->time;
    tick_rows *const rows = &state->rows;
    for (uint64_t position = state->position; position < end; position++) {
        const tick_operation *op = operations + order[position];
        unsigned status = 0;
        int reason = TICK_DONE;
        if (takes_long(op->kind) && state->look) { /* not within a row, which would be left half filled */
            state->position = position;
            return TICK_LOOK;
        }
        if (op->account != state->account && state->spent)
            begin_account(state, op->account);
        switch ((enum tick_kind)op->kind) {
        case TICK_CALLER:
            if (op->from <= state->tick && state->tick < op->until)
                reason = TICK_CALLER_ACTS;
            break;
        case TICK_GATHER_4: gather_4(op); break;
        case TICK_GATHER_8: gather_8(op, op->buffer); break;
        case TICK_SCATTER_4: scatter_4(op); break;
        case TICK_SCATTER_8: scatter_8(op); break;
        case TICK_WIDEN: widen(op); break;
        case TICK_NARROW: narrow(op); break;
        case TICK_CONVERT:
            if (!convert(op))
                reason = TICK_NOT_FINITE;
            break;
        case TICK_FINITE:
            if (!all_finite(op))
                reason = TICK_NOT_FINITE;
            break;
        case TICK_VALUES:
            status = ((values_function)op->function)(op->instance, op->references, op->count, op->buffer);
            break;
        case TICK_ARRAYS:
            status = ((arrays_function)op->function)(op->instance, op->references, op->count, op->buffer, op->values);
            break;
        case TICK_STEP_1:
        case TICK_STEP_2:
        case TICK_STEP_3: status = step(op, op->kind, time); break;
        case TICK_BEGIN: begin(op, state); break;
        case TICK_FINISH:
            while (!job_finish(state->pool, state->jobs + op->part, PATIENCE)) {
                if (state->look) {
                    state->position = position;
                    return TICK_LOOK;
                }
            }
            if (state->jobs[op->part].status | state->jobs[op->part].logged)
                reason = TICK_CALLER_ACTS;
            break;
        case TICK_REQUEST:
            if (request_begin(op->instance, (int32_t)op->part + 1, (int64_t)op->count, time, op->length, state->links,
                              state->link_count) != REQUEST_DONE)
                reason = TICK_CALLER_ACTS;
            break;
        case TICK_ANSWER: reason = answer(op, state); break;
        case TICK_ROW:
            if (rows->count < rows->size)
                rows->times[rows->count++] = time;
            else
                reason = TICK_ROWS_FULL;
            break;
        case TICK_RECORD_REALS:
        case TICK_RECORD_WIDE: gather_8(op, row_of(op, rows)); break;
        case TICK_RECORD_INTEGERS: integers_as_reals(op, row_of(op, rows)); break;
        case TICK_COPY: memcpy(op->buffer, op->source, op->count); break;
        case TICK_RECORD_COPY: memcpy((char *)row_of(op, rows) + 8 * op->values, op->source, 8 * op->count); break;
        case TICK_ADD:
        case TICK_MULTIPLY:
        case TICK_HOLD_4:
        case TICK_HOLD_8:
        case TICK_DELAY_4:
        case TICK_DELAY_8: tick_alter(op, state->tick); break;
        case TICK_PACE:
            if (!pace_wait(op, time, &state->look))
                reason = TICK_LOOK;
            break;
        }
        if (status) {
            state->status = status;
            reason = TICK_STATUS;
        }
        if (reason != TICK_DONE) {
            state->position = position;
            return reason;
        }
    }
    return TICK_DONE;
}

static int run_ticks(tick_state *state)
{
    for (;;) {
        if (!state->begun) {
            if (state->tick >= state->until)
                return TICK_DONE;
            state->time = (double)(state->origin + state->tick * state->length) / state->second;
            state->position = state->begins[(uint64_t)state->tick % state->cycle];
            state->begun = 1;
        }
        const int reason = run_tick(state);
        if (reason != TICK_DONE)
            return reason;
        state->begun = 0;
        state->tick++;
        if (state->look)
            return TICK_LOOK;
    }
}

int tick_run(tick_state *state)
{
    if (state->spent)
        begin_account(state, state->account);
    const int reason = run_ticks(state);
    if (state->spent && (reason == TICK_DONE || reason == TICK_LOOK)) {
        begin_account(state, 0);
        if (reason == TICK_DONE)
            state->stamp = 0;
    }
    return reason;
}

int tick_step(tick_state *state, int64_t last)
{
    if (state->tick >= last)
        return TICK_AT_LAST;
    state->until = state->tick + 1;
    return tick_run(state);
}

uint64_t tick_stamp(void)
{
    return clock_stamp();
}

void tick_layout(size_t sizes[3])
{
    sizes[0] = TICK_LAYOUT;
    sizes[1] = sizeof(tick_operation);
    sizes[2] = sizeof(tick_state);
}
