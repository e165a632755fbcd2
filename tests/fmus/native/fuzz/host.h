/* A host for fuzzing the FMI layer: what it reads its choices from, memory and log lines that it counts. */
#ifndef FUZZ_HOST_H
#define FUZZ_HOST_H

#include <stddef.h>
#include <stdint.h>

#include "fmi2.h"
#include "identity.h"
#include "port_table.h"

enum { TEXT = 256 }; /* bytes of a string variable */

/* The bytes that the fuzzer gives; after their end all choices are 0. */
typedef struct Input {
    const uint8_t *bytes;
    size_t left;
} Input;

unsigned choose(Input *input, unsigned count); /* 0 .. count - 1 */
double odd_number(Input *input);

extern const fmi2CallbackFunctions host_functions;
extern unsigned long lines;   /* that were logged */
extern char last_line[2000];
extern long blocks;           /* of memory that are not freed */
extern long memory_left;      /* blocks that the host still gives; -1: any number */

/* References of all variables of a kind; and of real ones with a flag, whose number is returned. */
fmi2ValueReference first_of(Kind kind);
size_t reals_with(int flag, const fmi2ValueReference **references);

/* Print a reason and the last log line, and abort. */
void fail(const char *format, ...);

/* FNV-1a of 64 bits, little-endian: the last 8 bytes of a serialised state. */
void digest(const uint8_t *bytes, size_t size, uint8_t sum[8]);

#endif
