/* Numbers, texts and lists of a program file. */
#ifndef BUNDLE_READER_H
#define BUNDLE_READER_H

#include "bundle.h"

typedef struct {
    bundle_t *bundle;
    const unsigned char *at, *end;
    int bad; /* shorter than it says, or no memory */
} reader_t;

const void *read_bytes(reader_t *in, size_t size);
uint32_t read_count(reader_t *in);
int64_t read_whole(reader_t *in);
double read_real(reader_t *in);
const char *read_text(reader_t *in);
counts_t read_counts(reader_t *in);

/* Return memory for so many things that follow, each of which takes 4 bytes of the file or more. */
void *read_memory(reader_t *in, uint32_t number, size_t size);

/* Lists of a length that is known; there may be no Reals at all. */
int64_t *read_positions(reader_t *in, uint32_t expected);
double *read_reals(reader_t *in, uint32_t expected);

/* Note that the file is damaged if a number is not below another one, and the largest number of values in a call. */
void read_limit(reader_t *in, uint32_t value, uint32_t below);
void read_largest(reader_t *in, uint32_t number);

#endif
