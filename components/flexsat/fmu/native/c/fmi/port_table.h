/* The ports of the component, as the generated ports.c lists them: ordered by kind, and by places among their kind.

In FMI 2.0 value references count the scalars of all kinds, reals first, so that no two variables have the same. In FMI
3.0 they count the ports, in the order of the list, from 1 on; 0 is the time. */
#ifndef FLEXSAT_PORT_TABLE_H
#define FLEXSAT_PORT_TABLE_H

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

struct Component;

typedef struct PortTable {
    int counts[KINDS];     /* scalars of each kind */
    int variables;         /* scalars of all kinds */
    int ports;
    int first_real_output; /* place; outputs stand together */
    int real_outputs;
    int stepped_outputs;   /* of them: those up to the last that is not on demand */
    int feeds_on_demand;   /* whether outputs on demand depend on inputs */
    const char *element;   /* format of an element's name: from that of its port, and its number */
    int (*differentiate)(struct Component *component, const double *seed, double *change); /* of component.h, or NULL */
} PortTable;

extern const PortTable port_table;
extern const Port ports[];                       /* as many as port_table.ports */
extern const unsigned short port_of_reference[]; /* as many as port_table.variables */

#endif
