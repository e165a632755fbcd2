/* The ports of the component, as the generated ports.c lists them: ordered by kind, and by places among their kind.

Value references count the scalars of all kinds, reals first, so that no two variables have the same. */
#ifndef FLEXSAT_PORT_TABLE_H
#define FLEXSAT_PORT_TABLE_H

#include "ports.h"

typedef enum { REAL, INTEGER, BOOLEAN, STRING, KINDS } Kind;

enum { /* flags of a port */
    INPUT = 1,
    OUTPUT = 2,
    PARAMETER = 4,
    TUNABLE = 8,         /* a parameter that may be set during a run */
    ARRAY = 16,          /* its scalars are numbered from 1 */
    ON_DEMAND = 32,      /* an output that is computed when it is read */
    FOLLOWS_INPUTS = 64, /* an output that is computed again if it is read after inputs were set */
    STARTS = 128         /* the start of a run depends on it */
};

typedef struct Port {
    const char *name;
    Kind kind;
    int flags;
    int first;                       /* place of its first scalar among those of its kind */
    int size;                        /* scalars */
    double least, greatest;          /* of a real or an integer; the largest double where there is no limit */
    const char *lower, *upper;       /* the same as text; NULL: no limit */
    double start;                    /* value of all its scalars before initialisation; of an output 0 */
    const double *starts;            /* one each, where they differ; else NULL */
    const char *text;                /* the start of a string */
} Port;

extern const Port ports[PORT_COUNT];
extern const unsigned short port_of_reference[VARIABLE_COUNT];

#endif
