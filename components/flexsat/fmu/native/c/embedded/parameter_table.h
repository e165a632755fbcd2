/* The parameters of the exported controller by the places of the FMU's: a table that is generated with the header. */
#ifndef FLEXSAT_PARAMETER_TABLE_H
#define FLEXSAT_PARAMETER_TABLE_H

#include <stddef.h>

#include "flexsat_controller.h"

typedef enum { PARAMETER_REAL, PARAMETER_BOOLEAN, PARAMETER_CHOICE } ParameterKind;

typedef struct ParameterEntry {
    const char *name;
    ParameterKind kind;
    size_t offset;              /* in FlexsatParameters */
    int place, size;            /* among the FMU's values of its kind */
    double least, greatest;     /* of a real */
    const char *const *choices; /* texts of a choice, of which there are `size` */
} ParameterEntry;

typedef struct ValueCounts {
    int reals, booleans, texts;
} ValueCounts;

extern const ValueCounts value_counts; /* of the FMU's ports */
extern const ParameterEntry parameter_table[];
extern const int parameter_count;
extern const char *const design_name; /* of the only design that is in the export */

#endif
