/* The types of FMI 3.0, as the standard names them, and those of the functions that a bundle calls. */
#ifndef BUNDLE_FMI3_H
#define BUNDLE_FMI3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define FMI3_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI3_EXPORT __attribute__((visibility("default")))
#else
#define FMI3_EXPORT
typedef fmi3Instance (*fmi3InstantiateFunction)(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                fmi3Boolean, fmi3Boolean, const fmi3ValueReference[], size_t,
                                                fmi3InstanceEnvironment, fmi3LogMessageCallback,
                                                fmi3IntermediateUpdateCallback);
typedef fmi3Status (*fmi3SetDebugLoggingFunction)(fmi3Instance, fmi3Boolean, size_t, const fmi3String[]);
typedef fmi3Status (*fmi3EnterInitializationFunction)(fmi3Instance, fmi3Boolean, fmi3Float64, fmi3Float64, fmi3Boolean,
                                                      fmi3Float64);
typedef fmi3Status (*fmi3DoStepFunction)(fmi3Instance, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Boolean *,
                                         fmi3Boolean *, fmi3Boolean *, fmi3Float64 *);
/* all of get and set that have a number of values; these are those of the type */
typedef fmi3Status (*fmi3GetFunction)(fmi3Instance, const fmi3ValueReference[], size_t, void *, size_t);
typedef fmi3Status (*fmi3SetFunction)(fmi3Instance, const fmi3ValueReference[], size_t, const void *, size_t);

#endif

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
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

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);

typedef fmi3Instance (*fmi3InstantiateFunction)(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                fmi3Boolean, fmi3Boolean, const fmi3ValueReference[], size_t,
                                                fmi3InstanceEnvironment, fmi3LogMessageCallback,
                                                fmi3IntermediateUpdateCallback);
typedef fmi3Status (*fmi3SetDebugLoggingFunction)(fmi3Instance, fmi3Boolean, size_t, const fmi3String[]);
typedef fmi3Status (*fmi3EnterInitializationFunction)(fmi3Instance, fmi3Boolean, fmi3Float64, fmi3Float64, fmi3Boolean,
                                                      fmi3Float64);
typedef fmi3Status (*fmi3DoStepFunction)(fmi3Instance, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Boolean *,
                                         fmi3Boolean *, fmi3Boolean *, fmi3Float64 *);
/* all of get and set that have a number of values; these are those of the type. A status has the size of an int. */
typedef int (*fmi3GetFunction)(fmi3Instance, const fmi3ValueReference[], size_t, void *, size_t);
typedef int (*fmi3SetFunction)(fmi3Instance, const fmi3ValueReference[], size_t, const void *, size_t);

#endif
