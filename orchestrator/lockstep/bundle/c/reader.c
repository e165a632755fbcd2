#include "reader.h"

#include <string.h>

#include "memory.h"

const void *read_bytes(reader_t *in, size_t size)
{
    static const double zeros[2];
    const void *found = in->at;

    if (in->bad || size > (size_t)(in->end - in->at)) {
        in->bad = 1;
        return zeros;
    }
    in->at += size;
    return found;
}

uint32_t read_count(reader_t *in)
{
    uint32_t value;

    memcpy(&value, read_bytes(in, sizeof value), sizeof value);
    return value;
}

int64_t read_whole(reader_t *in)
{
    int64_t value;

    memcpy(&value, read_bytes(in, sizeof value), sizeof value);
    return value;
}

double read_real(reader_t *in)
{
    double value;

    memcpy(&value, read_bytes(in, sizeof value), sizeof value);
    return value;
}

const char *read_text(reader_t *in)
{
    uint32_t length = read_count(in);
    const char *found = read_bytes(in, (size_t)length + 1);

    return in->bad ? "" : found;
}

/* Return memory for so many things that follow, each of which takes 4 bytes of the file or more. */
void *read_memory(reader_t *in, uint32_t number, size_t size)
{
    void *found = NULL;

    if (!in->bad && number <= (size_t)(in->end - in->at) / 4)
        found = keep(in->bundle, number, size);
    if (found == NULL)
        in->bad = 1;
    return found;
}

counts_t read_counts(reader_t *in)
{
    counts_t found = {0, NULL};
    uint32_t number = read_count(in);

    found.items = read_memory(in, number, sizeof *found.items);
    if (found.items != NULL) {
        const void *content = read_bytes(in, number * sizeof *found.items);
        found.count = in->bad ? 0 : number;
        memcpy(found.items, content, found.count * sizeof *found.items);
    }
    return found;
}

/* As counts, for positions of 64 bits. */
int64_t *read_positions(reader_t *in, uint32_t expected)
{
    counts_t found = read_counts(in);
    int64_t *wide = in->bad ? NULL : keep(in->bundle, found.count, sizeof *wide);

    if (wide == NULL || found.count != expected) {
        in->bad = 1;
        return NULL;
    }
    for (uint32_t k = 0; k < found.count; k++)
        wide[k] = (int64_t)found.items[k];
    return wide;
}

double *read_reals(reader_t *in, uint32_t expected)
{
    uint32_t number = read_count(in);
    const void *content;
    double *found;

    if (number == 0)
        return NULL;
    found = read_memory(in, number, sizeof *found);
    if (found == NULL || number != expected) {
        in->bad = 1;
        return NULL;
    }
    content = read_bytes(in, number * sizeof *found);
    if (!in->bad)
        memcpy(found, content, number * sizeof *found);
    return found;
}

void read_limit(reader_t *in, uint32_t value, uint32_t below)
{
    if (value >= below)
        in->bad = 1;
}

void read_largest(reader_t *in, uint32_t number)
{
    if (number > in->bundle->most_values)
        in->bundle->most_values = number;
}
