#include "host.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

unsigned long lines;
char last_line[2000];
long blocks, memory_left = -1;

static void logger(void *environment, fmi2String instance, fmi2Status status, fmi2String category, fmi2String message,
                   ...)
{
    va_list arguments;

    (void)environment;
    if (instance == NULL || category == NULL || strcmp(category, "logStatusError") != 0)
        fail("a log line without instance, or of another category");
    if (status != fmi2Warning && status != fmi2Discard && status != fmi2Error)
        fail("a log line with status %d", (int)status);
    va_start(arguments, message);
    vsnprintf(last_line, sizeof last_line, message, arguments);
    va_end(arguments);
    if (strchr(last_line, '\n') != NULL)
        fail("more than one line");
    lines++;
}

static void *give(size_t count, size_t size)
{
    if (memory_left == 0)
        return NULL;
    if (memory_left > 0)
        memory_left--;
    blocks++;
    return calloc(count, size);
}

static void take_back(void *block)
{
    if (block != NULL)
        blocks--;
    free(block);
}

const fmi2CallbackFunctions host_functions = {logger, give, take_back, NULL, NULL};

void fail(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, "\nlast log line: %s\n", last_line);
    abort();
}

unsigned choose(Input *input, unsigned count)
{
    unsigned value;

    if (input->left == 0)
        return 0;
    value = *input->bytes++;
    input->left--;
    return value % count;
}

double odd_number(Input *input)
{
    static const double odd[] = {0.0,    -0.0,   1.0,    -1.0,   0.5,   1e-3,  1e-9, -1e-9, 5e-324, 1e-310, 1e3,
                                 -1e3,   1e6,    1e9,    2147483647.0,  2147483648.0, -2147483649.0,
                                 9.1e15, 1.9e19, 1e100,  -1e100, 1e308, -1e308, 1.7976931348623157e308};
    const unsigned count = sizeof odd / sizeof *odd, which = choose(input, count + 6);
    double value = 0.0;

    if (which < count)
        return odd[which];
    switch (which - count) {
    case 0: return (double)NAN;
    case 1: return (double)INFINITY;
    case 2: return -(double)INFINITY;
    case 3: return ((double)choose(input, 256) - 128.0) / 64.0;
    case 4: return ((double)choose(input, 256) - 128.0) * 1e-4;
    default:
        if (input->left >= sizeof value) {
            memcpy(&value, input->bytes, sizeof value);
            input->bytes += sizeof value;
            input->left -= sizeof value;
        }
        return value;
    }
}

fmi2ValueReference first_of(Kind kind)
{
    fmi2ValueReference first = 0;
    int k;

    for (k = 0; k < (int)kind; k++)
        first += (fmi2ValueReference)port_table.counts[k];
    return first;
}

size_t reals_with(int flag, const fmi2ValueReference **references)
{
    static fmi2ValueReference *found[3];
    static size_t counts[3];
    const int which = flag == INPUT ? 0 : flag == OUTPUT ? 1 : 2;
    int k;

    if (found[which] == NULL) {
        found[which] = calloc((size_t)port_table.counts[REAL] + 1, sizeof **found);
        for (k = 0; k < port_table.counts[REAL]; k++)
            if (ports[port_of_reference[k]].flags & flag)
                found[which][counts[which]++] = (fmi2ValueReference)k;
    }
    *references = found[which];
    return counts[which];
}

void digest(const uint8_t *bytes, size_t size, uint8_t sum[8])
{
    uint64_t total = UINT64_C(0xcbf29ce484222325);
    size_t k;

    for (k = 0; k < size; k++)
        total = (total ^ bytes[k]) * UINT64_C(0x100000001b3);
    for (k = 0; k < 8; k++)
        sum[k] = (uint8_t)(total >> (8 * k));
}
