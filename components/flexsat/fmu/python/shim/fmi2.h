/* FMI 2.0 for co-simulation: the types and functions that the shim intercepts or forwards. */

#ifndef FLEXSAT_SHIM_FMI2_H
#define FLEXSAT_SHIM_FMI2_H

#include <stddef.h>

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
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

/* X(name, parameters, arguments) for each function that is forwarded as it is; `i` is the wrapper's instance. */
#define FORWARDED(X)                                                                                                   \
    X(fmi2SetDebugLogging, (fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]),                 \
      (i, on, n, categories))                                                                                          \
    X(fmi2SetupExperiment,                                                                                             \
      (fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends, fmi2Real stop),     \
      (i, defined, tolerance, start, ends, stop))                                                                      \
    X(fmi2EnterInitializationMode, (fmi2Component c), (i))                                                             \
    X(fmi2ExitInitializationMode, (fmi2Component c), (i))                                                              \
    X(fmi2Terminate, (fmi2Component c), (i))                                                                           \
    X(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer values[]),                \
      (i, vr, n, values))                                                                                              \
    X(fmi2GetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String values[]),                  \
      (i, vr, n, values))                                                                                              \
    X(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer values[]),          \
      (i, vr, n, values))                                                                                              \
    X(fmi2SetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String values[]),            \
      (i, vr, n, values))                                                                                              \
    X(fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate *state), (i, state))                                             \
    X(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate state), (i, state))                                              \
    X(fmi2FreeFMUstate, (fmi2Component c, fmi2FMUstate *state), (i, state))                                            \
    X(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate state, size_t *size), (i, state, size))               \
    X(fmi2SerializeFMUstate, (fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size),                     \
      (i, state, bytes, size))                                                                                         \
    X(fmi2DeSerializeFMUstate, (fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state),            \
      (i, bytes, size, state))                                                                                         \
    X(fmi2GetDirectionalDerivative,                                                                                    \
      (fmi2Component c, const fmi2ValueReference unknown[], size_t nu, const fmi2ValueReference known[], size_t nk,    \
       const fmi2Real seed[], fmi2Real sensitivity[]),                                                                 \
      (i, unknown, nu, known, nk, seed, sensitivity))                                                                  \
    X(fmi2SetRealInputDerivatives,                                                                                     \
      (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], const fmi2Real values[]),  \
      (i, vr, n, order, values))                                                                                       \
    X(fmi2GetRealOutputDerivatives,                                                                                    \
      (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], fmi2Real values[]),        \
      (i, vr, n, order, values))                                                                                       \
    X(fmi2DoStep, (fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean noSetFMUStatePrior),                     \
      (i, time, step, noSetFMUStatePrior))                                                                             \
    X(fmi2CancelStep, (fmi2Component c), (i))                                                                          \
    X(fmi2GetStatus, (fmi2Component c, int kind, fmi2Status *value), (i, kind, value))                                 \
    X(fmi2GetRealStatus, (fmi2Component c, int kind, fmi2Real *value), (i, kind, value))                               \
    X(fmi2GetIntegerStatus, (fmi2Component c, int kind, fmi2Integer *value), (i, kind, value))                         \
    X(fmi2GetBooleanStatus, (fmi2Component c, int kind, fmi2Boolean *value), (i, kind, value))                         \
    X(fmi2GetStringStatus, (fmi2Component c, int kind, fmi2String *value), (i, kind, value))

/* X(name, parameters) for each function that the shim intercepts. */
#define INTERCEPTED(X)                                                                                                 \
    X(fmi2Reset, (fmi2Component c))                                                                                    \
    X(fmi2GetReal, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]))                      \
    X(fmi2SetReal, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[]))                \
    X(fmi2GetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean values[]))                \
    X(fmi2SetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean values[]))

#endif
