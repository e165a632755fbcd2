/* FMI 2.0 for co-simulation: the types and functions that the shim implements, and what it calls of the wrapper. */

#ifndef FLEXSAT_SHIM_FMI2_H
#define FLEXSAT_SHIM_FMI2_H

#include <stddef.h>

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef const char *fmi2String;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Byte;
typedef unsigned int fmi2ValueReference;
typedef void *fmi2Component;
typedef void *fmi2FMUstate;

typedef struct {
    void (*logger)(void *environment, fmi2String instance, fmi2Status status, fmi2String category, fmi2String message,
                   ...);
    void *(*allocateMemory)(size_t count, size_t size);
    void (*freeMemory)(void *memory);
    void (*stepFinished)(void *environment, fmi2Status status);
    void *componentEnvironment;
} fmi2CallbackFunctions;

/* X(name, parameters) for each function of the wrapper that the shim calls; all but two return a status. */
#define WRAPPED(X)                                                                                                     \
    X(fmi2SetupExperiment, (fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real))                  \
    X(fmi2EnterInitializationMode, (fmi2Component c))                                                                  \
    X(fmi2ExitInitializationMode, (fmi2Component c))                                                                   \
    X(fmi2DoStep, (fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean))                                        \
    X(fmi2Terminate, (fmi2Component c))                                                                                \
    X(fmi2Reset, (fmi2Component c))                                                                                    \
    X(fmi2GetReal, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]))                      \
    X(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer values[]))                \
    X(fmi2GetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean values[]))                \
    X(fmi2GetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String values[]))                  \
    X(fmi2SetReal, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[]))                \
    X(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer values[]))          \
    X(fmi2SetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean values[]))          \
    X(fmi2SetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String values[]))            \
    X(fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate *state))                                                         \
    X(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate state))                                                          \
    X(fmi2FreeFMUstate, (fmi2Component c, fmi2FMUstate *state))                                                        \
    X(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate state, size_t *size))                                 \
    X(fmi2SerializeFMUstate, (fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size))                     \
    X(fmi2DeSerializeFMUstate, (fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state))

#endif
