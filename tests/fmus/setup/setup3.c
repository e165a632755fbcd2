/* An FMU of FMI 3.0: y is p, and tolerance is what the host passed when initialization began, or -1. */

#include <stdlib.h>

#include "fmi3Functions.h"

enum { P, Y, TOLERANCE, REALS };

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference needed[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)needed;
    (void)count, (void)environment, (void)log, (void)update;
    return calloc(REALS, sizeof(double));
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean defined, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean ends, fmi3Float64 stop) {
    (void)start, (void)ends, (void)stop;
    ((double *)c)[TOLERANCE] = defined ? tolerance : -1.0;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)keep;
    ((double *)c)[Y] = ((double *)c)[P];
    *event = *end = *early = 0;
    *reached = time + step;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Float64 v[], size_t count) {
    for (size_t k = 0; k < n && k < count; k++) v[k] = ((double *)c)[r[k]];
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3Float64 v[], size_t count) {
    for (size_t k = 0; k < n && k < count; k++) ((double *)c)[r[k]] = v[k];
    return fmi3OK;
}
