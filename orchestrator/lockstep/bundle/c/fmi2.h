/* The types of FMI 2.0 and the functions of co-simulation, as the standard names them. */
#ifndef BUNDLE_FMI2_H
#define BUNDLE_FMI2_H

#include <stddef.h>

#if defined(_WIN32)
#define FMI2_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI2_EXPORT __attribute__((visibility("default")))
#else
#define FMI2_EXPORT
#endif

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;

enum { fmi2False, fmi2True };

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
typedef void *(*fmi2CallbackAllocateMemory)(size_t, size_t);
typedef void (*fmi2CallbackFreeMemory)(void *);
typedef void (*fmi2StepFinished)(fmi2ComponentEnvironment, fmi2Status);

typedef struct {
    fmi2CallbackLogger logger;
    fmi2CallbackAllocateMemory allocateMemory;
    fmi2CallbackFreeMemory freeMemory;
    fmi2StepFinished stepFinished;
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef const char *(*fmi2GetVersionFunction)(void);
typedef fmi2Component (*fmi2InstantiateFunction)(fmi2String, fmi2Type, fmi2String, fmi2String,
                                                 const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean);
typedef void (*fmi2FreeInstanceFunction)(fmi2Component);
typedef fmi2Status (*fmi2PlainFunction)(fmi2Component);
typedef fmi2Status (*fmi2SetDebugLoggingFunction)(fmi2Component, fmi2Boolean, size_t, const fmi2String[]);
typedef fmi2Status (*fmi2SetupExperimentFunction)(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
typedef fmi2Status (*fmi2DoStepFunction)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
/* all eight of get and set; the values are those of the type */
typedef fmi2Status (*fmi2GetFunction)(fmi2Component, const fmi2ValueReference[], size_t, void *);
typedef fmi2Status (*fmi2SetFunction)(fmi2Component, const fmi2ValueReference[], size_t, const void *);
typedef fmi2Status (*fmi2GetStateFunction)(fmi2Component, fmi2FMUstate *);
typedef fmi2Status (*fmi2SetStateFunction)(fmi2Component, fmi2FMUstate);
typedef fmi2Status (*fmi2StateSizeFunction)(fmi2Component, fmi2FMUstate, size_t *);
typedef fmi2Status (*fmi2SerializeFunction)(fmi2Component, fmi2FMUstate, fmi2Byte[], size_t);
typedef fmi2Status (*fmi2DeSerializeFunction)(fmi2Component, const fmi2Byte[], size_t, fmi2FMUstate *);
typedef fmi2Status (*fmi2GetRealStatusFunction)(fmi2Component, fmi2StatusKind, fmi2Real *);
typedef fmi2Status (*fmi2GetBooleanStatusFunction)(fmi2Component, fmi2StatusKind, fmi2Boolean *);

#endif
