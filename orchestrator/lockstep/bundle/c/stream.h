/* Values that are measured, written to bytes or read from them, by one function for all three. */
#ifndef BUNDLE_STREAM_H
#define BUNDLE_STREAM_H

#include <stddef.h>

typedef enum { MEASURE, WRITE, READ } direction_t;

typedef struct {
    direction_t direction;
    unsigned char *at, *end;
    size_t size;
    int bad;
} stream_t;

void pass(stream_t *stream, void *value, size_t size);
void pass_text(stream_t *stream, char **text); /* one of malloc() */

#endif
