#include "stream.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void pass(stream_t *stream, void *value, size_t size)
{
    stream->size += size;
    if (stream->direction == MEASURE || size == 0)
        return;
    if (size > (size_t)(stream->end - stream->at)) {
        stream->bad = 1;
        return;
    }
    if (stream->direction == WRITE)
        memcpy(stream->at, value, size);
    else
        memcpy(value, stream->at, size);
    stream->at += size;
}

void pass_text(stream_t *stream, char **text)
{
    uint32_t length = stream->direction == READ || *text == NULL ? 0 : (uint32_t)strlen(*text);
    char *copy;

    pass(stream, &length, sizeof length);
    if (stream->direction != READ) {
        pass(stream, *text, length);
        return;
    }
    if (stream->bad || length > (size_t)(stream->end - stream->at) || (copy = malloc((size_t)length + 1)) == NULL) {
        stream->bad = 1;
        return;
    }
    pass(stream, copy, length);
    copy[length] = '\0';
    free(*text);
    *text = copy;
}
