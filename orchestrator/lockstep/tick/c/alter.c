/* Faults that alter values before they are set: see tick.h for the fields, and lockstep/faults/effects.py. */
#include "alter.h"

#include <string.h>

/* What `history` of an operation holds. */
enum { HELD = 0 };                                       /* of a TICK_HOLD: whether a value is held, 2 for ever */
enum { FIRST = 0, COUNT = 1, CAPACITY = 2, DELAY = 3, TICKS = 4 }; /* of a TICK_DELAY: a ring of transfers */

static void take(char *values, const tick_operation *op, size_t width)
{
    const char *buffer = op->buffer;
    for (size_t k = 0; k < op->count; k++)
        memcpy(values + width * k, buffer + width * (size_t)op->index[k], width);
}

static void put(const char *values, const tick_operation *op, size_t width)
{
    char *buffer = op->buffer;
    for (size_t k = 0; k < op->count; k++)
        memcpy(buffer + width * (size_t)op->index[k], values + width * k, width);
}

/* Keep the last values before the window, or the first if there are none, and hold them in it. */
static void hold(const tick_operation *op, int64_t tick, size_t width)
{
    int64_t *held = op->history + HELD;
    if (*held == 0 || (*held == 1 && tick < op->from)) {
        take(op->memory, op, width);
        *held = 1;
    }
    if (tick >= op->from)
        put(op->memory, op, width);
}

/* Keep what can still be needed, and give the oldest of it. */
static void delay(const tick_operation *op, int64_t tick, size_t width)
{
    int64_t *history = op->history, *ticks = op->history + TICKS;
    const int64_t capacity = history[CAPACITY];
    char *values = op->memory;
    const size_t size = width * op->count;
    const int64_t next = (history[FIRST] + history[COUNT]) % capacity;
    take(values + size * (size_t)next, op, width);
    ticks[next] = tick;
    history[COUNT]++;
    while (history[COUNT] > 1 && ticks[(history[FIRST] + 1) % capacity] <= tick - history[DELAY]) {
        history[FIRST] = (history[FIRST] + 1) % capacity;
        history[COUNT]--;
    }
    if (tick >= op->from)
        put(values + size * (size_t)history[FIRST], op, width);
}

void tick_alter(const tick_operation *op, int64_t tick)
{
    double *values = op->buffer;
    if (tick >= op->until)
        return;
    switch ((enum tick_kind)op->kind) {
    case TICK_ADD:
        for (size_t k = 0; tick >= op->from && k < op->count; k++)
            values[op->index[k]] += op->first[k];
        break;
    case TICK_MULTIPLY:
        for (size_t k = 0; tick >= op->from && k < op->count; k++)
            values[op->index[k]] *= op->first[k];
        break;
    case TICK_HOLD_4: hold(op, tick, 4); break;
    case TICK_HOLD_8: hold(op, tick, 8); break;
    case TICK_DELAY_4: delay(op, tick, 4); break;
    case TICK_DELAY_8: delay(op, tick, 8); break;
    default: break;
    }
}
