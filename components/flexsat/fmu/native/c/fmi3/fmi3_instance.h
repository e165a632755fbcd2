/* What the files of FMI 3.0 need of the FMI layer, and of each other. */
#ifndef FLEXSAT_FMI3_INSTANCE_H
#define FLEXSAT_FMI3_INSTANCE_H

#include "fmi3.h"
#include "instance.h"

#define TIME_REFERENCE 0 /* of the independent variable; those of the ports follow it */

/* fmi3_values.c */
/* Return the port of a reference, or NULL for the time and for references that no port has. */
const Port *port_of(fmi3ValueReference reference);
/* Refuse a reference that no variable of a type has. */
Status refuse_reference(Instance *instance, const char *call, const char *type, fmi3ValueReference reference);

#endif
