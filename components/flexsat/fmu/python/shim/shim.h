/* What the files of the shim share: an instance, the wrapper behind it, and how calls are refused and logged. */

#ifndef FLEXSAT_SHIM_H
#define FLEXSAT_SHIM_H

#include "fmi2.h"

#ifdef __x86_64__ /* the oldest versions of these symbols: it loads with an older glibc than that of its build */
__asm__(".symver dlopen,dlopen@GLIBC_2.2.5");
__asm__(".symver dlsym,dlsym@GLIBC_2.2.5");
__asm__(".symver dladdr,dladdr@GLIBC_2.2.5");
__asm__(".symver dlclose,dlclose@GLIBC_2.2.5");
__asm__(".symver dlerror,dlerror@GLIBC_2.2.5");
__asm__(".symver memcpy,memcpy@GLIBC_2.2.5");
#endif

#define EXPORTED __attribute__((visibility("default")))
#define CATEGORY "logStatusError" /* the only log category of these FMUs */

/* Strings that no variable has: one describes the shared buffers, writing the other refuses a call. */
#define BUFFERS_REFERENCE 0x7ffffff0u
#define REFUSAL_REFERENCE 0x7ffffff1u

enum { READ = 1, WRITE = 2, ON_DEMAND = 4, FOLLOWS = 8 };
enum { INSTANTIATED = 1, INITIALIZING, STEPPING, TERMINATED, FAILED };

/* Shared with the model, which writes all but `checking`; both write `inputs_set`. */
typedef struct {
    int access;   /* READ and WRITE: what needs no Python now */
    int outcome;  /* the status of the last call, where the wrapper cannot return it */
    int checking; /* not 0: a state that is set is examined, and not set */
    int phase;    /* of the life cycle */
    int inputs_set; /* not 0: since outputs that follow inputs were computed */
} Control;

typedef struct {
    size_t count;
    unsigned char *values; /* doubles or bytes */
    const unsigned char *access;
} Buffer;

/* The first value reference of each kind: no two variables of a model have the same one. */
typedef struct {
    fmi2ValueReference reals, integers, booleans, strings;
} First;

/* A saved state: what a host gets is the address of one of these. */
typedef struct State {
    struct State *next;
    fmi2FMUstate wrapped;
    size_t size; /* of its bytes */
} State;

typedef struct {
    fmi2Component wrapped;
    fmi2CallbackFunctions callbacks;         /* what the wrapper calls: they lead here */
    const fmi2CallbackFunctions *host;       /* may be NULL */
    char *name;                              /* as the host wrote it */
    int logging;                             /* messages of status fmi2OK too */
    int fatal;                               /* the wrapper may not be called any more */
    Control *control;                        /* NULL if there is no model: after a failed reset */
    const fmi2Real *now;                     /* the communication point that the model has reached */
    char guid[128];                          /* of the model */
    Buffer reals, booleans;
    size_t integers, strings;                /* how many there are */
    First first;                             /* value references of all kinds follow each other */
    State *states;
} Instance;

#define WRAPPED_MEMBER(name, parameters) fmi2Status(*name) parameters;
typedef struct {
    void *handle;
    fmi2Component (*fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging);
    void (*fmi2FreeInstance)(fmi2Component);
    WRAPPED(WRAPPED_MEMBER)
} Wrapper;
extern Wrapper wrapper;

/* messages.c */
void log_to_host(const fmi2CallbackFunctions *host, fmi2String name, fmi2Status status, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
void log_of_wrapper(void *instance, fmi2String name, fmi2Status status, fmi2String category, fmi2String message, ...);
fmi2Status refuse(Instance *instance, const char *format, ...) __attribute__((format(printf, 2, 3)));
int is_utf8(const char *text);
char *copy_as_utf8(const char *text);

/* calls.c */
fmi2Status begin(Instance *instance);
fmi2Status outcome(Instance *instance, fmi2Status status);

/* states.c */
void free_states(Instance *instance);

#endif
