/* What the files of FMI 2.0 need of the FMI layer. */
#ifndef FLEXSAT_FMI2_INSTANCE_H
#define FLEXSAT_FMI2_INSTANCE_H

#include "fmi2.h"
#include "instance.h"

typedef void (*Logger)(void *environment, fmi2String instance, fmi2Status status, fmi2String category,
                       fmi2String message, ...);

#endif
