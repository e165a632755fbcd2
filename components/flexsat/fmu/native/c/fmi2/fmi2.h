/* FMI 2.0 for co-simulation: its types, and the functions that the library exports. */
#ifndef FLEXSAT_FMI2_H
#define FLEXSAT_FMI2_H

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

/* Where several FMUs are linked into one program, the standard has their functions begin with the model's name. */
#ifdef FMI2_FUNCTION_PREFIX
#define FMI2_PASTE(prefix, name) prefix##name
#define FMI2_JOIN(prefix, name) FMI2_PASTE(prefix, name)
#define FMI2(name) FMI2_JOIN(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI2(name) name
#endif

#if defined(_WIN32) || defined(__CYGWIN__)
#define FMI2_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI2_EXPORT __attribute__((visibility("default")))
#else
#define FMI2_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

FMI2_EXPORT const char *FMI2(fmi2GetTypesPlatform)(void);
FMI2_EXPORT const char *FMI2(fmi2GetVersion)(void);
FMI2_EXPORT fmi2Component FMI2(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                                const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                                fmi2Boolean logging);
FMI2_EXPORT void FMI2(fmi2FreeInstance)(fmi2Component c);
FMI2_EXPORT fmi2Status FMI2(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n,
                                                 const fmi2String categories[]);

FMI2_EXPORT fmi2Status FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance,
                                                 fmi2Real start, fmi2Boolean ends, fmi2Real stop);
FMI2_EXPORT fmi2Status FMI2(fmi2EnterInitializationMode)(fmi2Component c);
FMI2_EXPORT fmi2Status FMI2(fmi2ExitInitializationMode)(fmi2Component c);
FMI2_EXPORT fmi2Status FMI2(fmi2Terminate)(fmi2Component c);
FMI2_EXPORT fmi2Status FMI2(fmi2Reset)(fmi2Component c);
FMI2_EXPORT fmi2Status FMI2(fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state_prior);
FMI2_EXPORT fmi2Status FMI2(fmi2CancelStep)(fmi2Component c);

FMI2_EXPORT fmi2Status FMI2(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                            fmi2Integer values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                            fmi2Boolean values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2GetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                           fmi2String values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                         const fmi2Real values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                            const fmi2Integer values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                            const fmi2Boolean values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2SetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                           const fmi2String values[]);

FMI2_EXPORT fmi2Status FMI2(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state);
FMI2_EXPORT fmi2Status FMI2(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state);
FMI2_EXPORT fmi2Status FMI2(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state);
FMI2_EXPORT fmi2Status FMI2(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size);
FMI2_EXPORT fmi2Status FMI2(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size);
FMI2_EXPORT fmi2Status FMI2(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                                     fmi2FMUstate *state);

FMI2_EXPORT fmi2Status FMI2(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[],
                                                          size_t unknowns, const fmi2ValueReference known[],
                                                          size_t knowns, const fmi2Real seed[], fmi2Real sensitivity[]);
FMI2_EXPORT fmi2Status FMI2(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                         const fmi2Integer order[], const fmi2Real values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                          const fmi2Integer order[], fmi2Real values[]);
FMI2_EXPORT fmi2Status FMI2(fmi2GetStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Status *value);
FMI2_EXPORT fmi2Status FMI2(fmi2GetRealStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Real *value);
FMI2_EXPORT fmi2Status FMI2(fmi2GetIntegerStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Integer *value);
FMI2_EXPORT fmi2Status FMI2(fmi2GetBooleanStatus)(fmi2Component c, fmi2StatusKind asked, fmi2Boolean *value);
FMI2_EXPORT fmi2Status FMI2(fmi2GetStringStatus)(fmi2Component c, fmi2StatusKind asked, fmi2String *value);

#ifdef __cplusplus
}
#endif

#endif
