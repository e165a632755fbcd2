/* FMI 3.0: its types, and the functions that the library exports. Hosts look for all functions, whatever kinds of
simulation an FMU is for. */
#ifndef FLEXSAT_FMI3_H
#define FLEXSAT_FMI3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum {
    fmi3Independent,
    fmi3Constant,
    fmi3Fixed,
    fmi3Tunable,
    fmi3Discrete,
    fmi3Dependent
} fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;
typedef uint32_t fmi3ValueReference;
typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                                       fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment environment);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment environment, fmi3Float64 time,
                                               fmi3Boolean set_requested, fmi3Boolean get_allowed,
                                               fmi3Boolean step_finished, fmi3Boolean can_return_early,
                                               fmi3Boolean *return_early, fmi3Float64 *early_time);

/* Where several FMUs are linked into one program, the standard has their functions begin with the model's name. */
#ifdef FMI3_FUNCTION_PREFIX
#define FMI3_PASTE(prefix, name) prefix##name
#define FMI3_JOIN(prefix, name) FMI3_PASTE(prefix, name)
#define FMI3(name) FMI3_JOIN(FMI3_FUNCTION_PREFIX, name)
#else
#define FMI3(name) name
#endif

#if defined(_WIN32) || defined(__CYGWIN__)
#define FMI3_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI3_EXPORT __attribute__((visibility("default")))
#else
#define FMI3_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

FMI3_EXPORT const char *FMI3(fmi3GetVersion)(void);
FMI3_EXPORT fmi3Instance FMI3(fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources,
                                                           fmi3Boolean visible, fmi3Boolean logging,
                                                           fmi3Boolean events, fmi3Boolean early_return,
                                                           const fmi3ValueReference intermediate[], size_t n,
                                                           fmi3InstanceEnvironment environment,
                                                           fmi3LogMessageCallback logger,
                                                           fmi3IntermediateUpdateCallback update);
FMI3_EXPORT fmi3Instance FMI3(fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                            fmi3Boolean visible, fmi3Boolean logging,
                                                            fmi3InstanceEnvironment environment,
                                                            fmi3LogMessageCallback logger);
FMI3_EXPORT fmi3Instance FMI3(fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token,
                                                                 fmi3String resources, fmi3Boolean visible,
                                                                 fmi3Boolean logging,
                                                                 fmi3InstanceEnvironment environment,
                                                                 fmi3LogMessageCallback logger,
                                                                 fmi3ClockUpdateCallback update,
                                                                 fmi3LockPreemptionCallback lock,
                                                                 fmi3UnlockPreemptionCallback unlock);
FMI3_EXPORT void FMI3(fmi3FreeInstance)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3SetDebugLogging)(fmi3Instance c, fmi3Boolean on, size_t n,
                                                 const fmi3String categories[]);

FMI3_EXPORT fmi3Status FMI3(fmi3EnterInitializationMode)(fmi3Instance c, fmi3Boolean defined, fmi3Float64 tolerance,
                                                         fmi3Float64 start, fmi3Boolean ends, fmi3Float64 stop);
FMI3_EXPORT fmi3Status FMI3(fmi3ExitInitializationMode)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3Terminate)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3Reset)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3DoStep)(fmi3Instance c, fmi3Float64 time, fmi3Float64 step,
                                        fmi3Boolean no_set_state_prior, fmi3Boolean *events, fmi3Boolean *ends,
                                        fmi3Boolean *early, fmi3Float64 *reached);

FMI3_EXPORT fmi3Status FMI3(fmi3GetFloat32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                            fmi3Float32 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetFloat64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                            fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetInt8)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int8 values[],
                                         size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetUInt8)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          fmi3UInt8 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetInt16)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          fmi3Int16 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetUInt16)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           fmi3UInt16 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetInt32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          fmi3Int32 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetUInt32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           fmi3UInt32 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetInt64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          fmi3Int64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetUInt64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           fmi3UInt64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetBoolean)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                            fmi3Boolean values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetString)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           fmi3String values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetBinary)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[],
                                           fmi3Binary values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetClock)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          fmi3Clock values[]);
FMI3_EXPORT fmi3Status FMI3(fmi3SetFloat32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                            const fmi3Float32 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetFloat64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                            const fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetInt8)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                         const fmi3Int8 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetUInt8)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          const fmi3UInt8 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetInt16)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          const fmi3Int16 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetUInt16)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           const fmi3UInt16 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetInt32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          const fmi3Int32 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetUInt32)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           const fmi3UInt32 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetInt64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          const fmi3Int64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetUInt64)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           const fmi3UInt64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetBoolean)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                            const fmi3Boolean values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetString)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           const fmi3String values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetBinary)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                           const size_t sizes[], const fmi3Binary values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3SetClock)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          const fmi3Clock values[]);

FMI3_EXPORT fmi3Status FMI3(fmi3GetFMUState)(fmi3Instance c, fmi3FMUState *state);
FMI3_EXPORT fmi3Status FMI3(fmi3SetFMUState)(fmi3Instance c, fmi3FMUState state);
FMI3_EXPORT fmi3Status FMI3(fmi3FreeFMUState)(fmi3Instance c, fmi3FMUState *state);
FMI3_EXPORT fmi3Status FMI3(fmi3SerializedFMUStateSize)(fmi3Instance c, fmi3FMUState state, size_t *size);
FMI3_EXPORT fmi3Status FMI3(fmi3SerializeFMUState)(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[],
                                                   size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3DeserializeFMUState)(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                                                     fmi3FMUState *state);

FMI3_EXPORT fmi3Status FMI3(fmi3GetDirectionalDerivative)(fmi3Instance c, const fmi3ValueReference unknowns[],
                                                          size_t n_unknowns, const fmi3ValueReference knowns[],
                                                          size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                                          fmi3Float64 sensitivity[], size_t n_sensitivity);
FMI3_EXPORT fmi3Status FMI3(fmi3GetAdjointDerivative)(fmi3Instance c, const fmi3ValueReference unknowns[],
                                                      size_t n_unknowns, const fmi3ValueReference knowns[],
                                                      size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                                      fmi3Float64 sensitivity[], size_t n_sensitivity);
FMI3_EXPORT fmi3Status FMI3(fmi3GetOutputDerivatives)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                      const fmi3Int32 orders[], fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetNumberOfVariableDependencies)(fmi3Instance c, fmi3ValueReference vr, size_t *n);
FMI3_EXPORT fmi3Status FMI3(fmi3GetVariableDependencies)(fmi3Instance c, fmi3ValueReference vr, size_t elements[],
                                                         fmi3ValueReference independents[],
                                                         size_t independent_elements[], fmi3DependencyKind kinds[],
                                                         size_t n);

FMI3_EXPORT fmi3Status FMI3(fmi3EnterConfigurationMode)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3ExitConfigurationMode)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3EnterEventMode)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3EnterStepMode)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3EvaluateDiscreteStates)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3UpdateDiscreteStates)(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *ends,
                                                      fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                                      fmi3Boolean *next_defined, fmi3Float64 *next);
FMI3_EXPORT fmi3Status FMI3(fmi3ActivateModelPartition)(fmi3Instance c, fmi3ValueReference vr, fmi3Float64 time);
FMI3_EXPORT fmi3Status FMI3(fmi3GetIntervalDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                    fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]);
FMI3_EXPORT fmi3Status FMI3(fmi3GetIntervalFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                     fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                                     fmi3IntervalQualifier qualifiers[]);
FMI3_EXPORT fmi3Status FMI3(fmi3GetShiftDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                 fmi3Float64 shifts[]);
FMI3_EXPORT fmi3Status FMI3(fmi3GetShiftFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                  fmi3UInt64 counters[], fmi3UInt64 resolutions[]);
FMI3_EXPORT fmi3Status FMI3(fmi3SetIntervalDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                    const fmi3Float64 intervals[]);
FMI3_EXPORT fmi3Status FMI3(fmi3SetIntervalFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                     const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]);
FMI3_EXPORT fmi3Status FMI3(fmi3SetShiftDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                 const fmi3Float64 shifts[]);
FMI3_EXPORT fmi3Status FMI3(fmi3SetShiftFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                                  const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]);

FMI3_EXPORT fmi3Status FMI3(fmi3EnterContinuousTimeMode)(fmi3Instance c);
FMI3_EXPORT fmi3Status FMI3(fmi3CompletedIntegratorStep)(fmi3Instance c, fmi3Boolean no_set_state_prior,
                                                         fmi3Boolean *events, fmi3Boolean *ends);
FMI3_EXPORT fmi3Status FMI3(fmi3SetTime)(fmi3Instance c, fmi3Float64 time);
FMI3_EXPORT fmi3Status FMI3(fmi3SetContinuousStates)(fmi3Instance c, const fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetContinuousStateDerivatives)(fmi3Instance c, fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetEventIndicators)(fmi3Instance c, fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetContinuousStates)(fmi3Instance c, fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetNominalsOfContinuousStates)(fmi3Instance c, fmi3Float64 values[], size_t size);
FMI3_EXPORT fmi3Status FMI3(fmi3GetNumberOfEventIndicators)(fmi3Instance c, size_t *n);
FMI3_EXPORT fmi3Status FMI3(fmi3GetNumberOfContinuousStates)(fmi3Instance c, size_t *n);

#ifdef __cplusplus
}
#endif

#endif
