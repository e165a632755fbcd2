/* The shim: the library that a host loads. It stands before pythonfmu's wrapper, which lies in the same folder:

   - It passes the wrapper a resource location that the wrapper accepts, whatever valid form of URI the host uses. The
     wrapper (pythonfmu 0.7) cuts off the first seven characters, decodes %20, and aborts when it finds no file there.
   - It logs what is missing, Python or a resource, where the wrapper would end the process.
   - It copies Reals and Booleans straight between the host and the buffers of the model where Python would do nothing
     but copy. The wrapper calls Python for each set and get, and builds four objects for each scalar.

   Every other call is forwarded, and so is any set or get that must be checked, refused or computed.
   shared_buffers.py defines where the values lie and which may be accessed; it states the same constants. */

#define _GNU_SOURCE
#include "fmi2.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifdef __x86_64__ /* the oldest versions of these symbols: it loads with an older glibc than that of its build */
__asm__(".symver dlopen,dlopen@GLIBC_2.2.5");
__asm__(".symver dlsym,dlsym@GLIBC_2.2.5");
__asm__(".symver dladdr,dladdr@GLIBC_2.2.5");
__asm__(".symver dlclose,dlclose@GLIBC_2.2.5");
__asm__(".symver dlerror,dlerror@GLIBC_2.2.5");
__asm__(".symver memcpy,memcpy@GLIBC_2.2.5");
#endif

#define EXPORTED __attribute__((visibility("default")))
#define WRAPPER "libpythonfmu-export.so"
#define MARKER "slavemodule.txt" /* in the resources: the wrapper opens it first of all */
#define CATEGORY "logStatusError"
#define BUFFERS_REFERENCE 0x7ffffff0u /* the String that describes the shared buffers; no variable has it */
enum { READ = 1, WRITE = 2, ON_DEMAND = 4 };

typedef struct {
    size_t count;
    unsigned char *values; /* doubles or bytes */
    const unsigned char *access;
} Buffer;

typedef struct {
    fmi2Component wrapped;
    const int *running; /* not 0 while values may be accessed; NULL if the model shares no buffers */
    Buffer reals, booleans;
} Instance;

#define MEMBER(name, parameters, ...) fmi2Status(*name) parameters;
static struct {
    void *handle;
    fmi2Component (*fmi2Instantiate)(fmi2String name, int type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging);
    void (*fmi2FreeInstance)(fmi2Component);
    FORWARDED(MEMBER)
    INTERCEPTED(MEMBER)
} wrapper;

/* Where errors are logged. */
typedef struct {
    const fmi2CallbackFunctions *functions;
    fmi2String name;
} Host;

static void log_error(const Host *host, const char *what, const char *detail) {
    if (host->functions && host->functions->logger)
        host->functions->logger(host->functions->componentEnvironment, host->name, fmi2Error, CATEGORY, "%s%s", what,
                                detail ? detail : "");
}

/* Write the folder of this library, with a slash at its end. */
static int own_folder(char *folder, size_t size) {
    Dl_info here;
    if (!dladdr((void *)own_folder, &here) || !here.dli_fname || !realpath(here.dli_fname, folder)) return 0;
    char *slash = strrchr(folder, '/');
    if (!slash || (size_t)(slash - folder) + 1 >= size) return 0;
    slash[1] = '\0';
    return 1;
}

/* Load Python with its symbols global, unless the process has it. */
static int find_python(const Host *host) {
    if (dlsym(RTLD_DEFAULT, "Py_IsInitialized")) return 1;
    if (dlopen(LIBPYTHON, RTLD_NOW | RTLD_GLOBAL)) return 1;
    log_error(host,
              "this FMU runs in Python, and there is none in this process nor " LIBPYTHON
              " on this machine; install it, or preload the library of another version",
              NULL);
    return 0;
}

static int load_wrapper(const Host *host) {
    char path[PATH_MAX + sizeof WRAPPER];
    if (wrapper.handle) return 1;
    if (!own_folder(path, PATH_MAX)) {
        log_error(host, "cannot find the folder of its own library", NULL);
        return 0;
    }
    strcat(path, WRAPPER);
    if (!find_python(host)) return 0;
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
        log_error(host, "cannot load pythonfmu's wrapper: ", dlerror());
        return 0;
    }
#define FIND(name, ...)                                                                                                \
    if (!(*(void **)&wrapper.name = dlsym(handle, #name))) {                                                           \
        log_error(host, WRAPPER " lacks ", #name);                                                                     \
        dlclose(handle);                                                                                               \
        return 0;                                                                                                      \
    }
    FIND(fmi2Instantiate)
    FIND(fmi2FreeInstance)
    FORWARDED(FIND)
    INTERCEPTED(FIND)
    wrapper.handle = handle;
    return 1;
}

/* The wrapper is unloaded with this library, as if the host had loaded it. */
__attribute__((destructor)) static void unload_wrapper(void) {
    if (wrapper.handle) dlclose(wrapper.handle);
    wrapper.handle = NULL;
}

static int hexadecimal(char letter) {
    if (letter >= '0' && letter <= '9') return letter - '0';
    if (letter >= 'a' && letter <= 'f') return letter - 'a' + 10;
    if (letter >= 'A' && letter <= 'F') return letter - 'A' + 10;
    return -1;
}

/* Write the path of a URI: file:///p, file://localhost/p, file:/p, or a bare path, percent-encoded or not. */
static int decode(const char *uri, char *path, size_t size) {
    if (!strncmp(uri, "file:", 5)) {
        uri += 5;
        if (!strncmp(uri, "//", 2)) {
            uri += 2;
            if (!strncmp(uri, "localhost/", 10)) uri += 9;
        }
    }
    size_t length = 0;
    for (; *uri; uri++) {
        if (length + 1 >= size) return 0;
        int high, low;
        if (*uri == '%' && (high = hexadecimal(uri[1])) >= 0 && (low = hexadecimal(uri[2])) >= 0) {
            path[length++] = (char)(16 * high + low);
            uri += 2;
        } else {
            path[length++] = *uri;
        }
    }
    while (length > 1 && path[length - 1] == '/') length--;
    path[length] = '\0';
    return length > 0;
}

static int holds_resources(const char *folder) {
    char marker[PATH_MAX + sizeof MARKER + 1];
    snprintf(marker, sizeof marker, "%s/" MARKER, folder);
    return access(marker, R_OK) == 0;
}

/* Write the location for the wrapper: the one that the host gave, or else the resources next to the binaries. */
static int locate(const Host *host, fmi2String given, char *location) {
    char folder[PATH_MAX];
    int found = given && decode(given, folder, sizeof folder) && holds_resources(folder);
    if (!found && given && !strncmp(given, "file://", 7) && strlen(given + 7) < sizeof folder) {
        strcpy(folder, given + 7); /* a host that encodes nothing, though the path holds a percent sign */
        found = holds_resources(folder);
    }
    if (!found && own_folder(folder, sizeof folder) && strlen(folder) + 16 < sizeof folder) {
        char own[PATH_MAX];
        strcat(folder, "../../resources");
        found = realpath(folder, own) && holds_resources(own);
        if (found) strcpy(folder, own);
    }
    if (!found) {
        log_error(host, "no resources at fmuResourceLocation = ", given ? given : "NULL");
        return 0;
    }
    if (strstr(folder, "%20")) {
        log_error(host, "the letters %20 in a path are a blank to pythonfmu's wrapper; unpack elsewhere than to ",
                  folder);
        return 0;
    }
    sprintf(location, "file://%s", folder);
    return 1;
}

/* Ask the model where its buffers lie. One that shares none gives no answer, and Python then does all the copying. */
static void connect(Instance *instance) {
    const fmi2ValueReference reference = BUFFERS_REFERENCE;
    fmi2String layout = NULL;
    instance->running = NULL;
    if (wrapper.fmi2GetString(instance->wrapped, &reference, 1, &layout) != fmi2OK || !layout) return;
    Buffer reals, booleans;
    const int *running;
    if (sscanf(layout, "buffers %p %zu %p %p %zu %p %p", (void **)&reals.values, &reals.count, (void **)&reals.access,
               (void **)&booleans.values, &booleans.count, (void **)&booleans.access, (void **)&running) != 7)
        return;
    instance->reals = reals;
    instance->booleans = booleans;
    instance->running = running;
}

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, int type, fmi2String guid, fmi2String resources,
                                       const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                       fmi2Boolean logging) {
    const Host host = {functions, name};
    char location[PATH_MAX + 8];
    if (!locate(&host, resources, location) || !load_wrapper(&host)) return NULL;
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->wrapped = wrapper.fmi2Instantiate(name, type, guid, location, functions, visible, logging);
    if (!instance->wrapped) {
        free(instance);
        return NULL;
    }
    connect(instance);
    return instance;
}

EXPORTED void fmi2FreeInstance(fmi2Component c) {
    Instance *instance = c;
    if (!instance) return;
    wrapper.fmi2FreeInstance(instance->wrapped);
    free(instance);
}

EXPORTED fmi2Status fmi2Reset(fmi2Component c) {
    Instance *instance = c;
    instance->running = NULL; /* the wrapper makes a new object, whose buffers lie elsewhere */
    fmi2Status status = wrapper.fmi2Reset(instance->wrapped);
    if (status == fmi2OK) connect(instance);
    return status;
}

#define FORWARD(name, parameters, arguments)                                                                           \
    EXPORTED fmi2Status name parameters {                                                                              \
        fmi2Component i = ((Instance *)c)->wrapped;                                                                    \
        return wrapper.name arguments;                                                                                 \
    }
FORWARDED(FORWARD)

/* Return whether all references allow `access`; `on_demand` becomes one that has to be computed first, if any. */
static int allowed(const Instance *instance, const Buffer *buffer, const fmi2ValueReference vr[], size_t n, int access,
                   const fmi2ValueReference **on_demand) {
    if (!instance->running || !*instance->running) return 0;
    for (size_t k = 0; k < n; k++) {
        if (vr[k] >= buffer->count || !(buffer->access[vr[k]] & access)) return 0;
        if (buffer->access[vr[k]] & ON_DEMAND) *on_demand = &vr[k];
    }
    return 1;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]) {
    Instance *instance = c;
    const fmi2ValueReference *on_demand = NULL;
    if (!allowed(instance, &instance->reals, vr, n, READ, &on_demand))
        return wrapper.fmi2GetReal(instance->wrapped, vr, n, values);
    if (on_demand) { /* Python computes all of them when one is asked for */
        fmi2Real computed;
        fmi2Status status = wrapper.fmi2GetReal(instance->wrapped, on_demand, 1, &computed);
        if (status > fmi2Warning) return status;
    }
    const fmi2Real *all = (const fmi2Real *)instance->reals.values;
    for (size_t k = 0; k < n; k++) values[k] = all[vr[k]];
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[]) {
    Instance *instance = c;
    const fmi2ValueReference *on_demand = NULL;
    int shared = allowed(instance, &instance->reals, vr, n, WRITE, &on_demand);
    for (size_t k = 0; shared && k < n; k++) shared = isfinite(values[k]); /* Python refuses it, by name */
    if (!shared) return wrapper.fmi2SetReal(instance->wrapped, vr, n, values);
    fmi2Real *all = (fmi2Real *)instance->reals.values;
    for (size_t k = 0; k < n; k++) all[vr[k]] = values[k];
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean values[]) {
    Instance *instance = c;
    const fmi2ValueReference *on_demand = NULL;
    if (!allowed(instance, &instance->booleans, vr, n, READ, &on_demand) || on_demand)
        return wrapper.fmi2GetBoolean(instance->wrapped, vr, n, values);
    for (size_t k = 0; k < n; k++) values[k] = instance->booleans.values[vr[k]] != 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                   const fmi2Boolean values[]) {
    Instance *instance = c;
    const fmi2ValueReference *on_demand = NULL;
    if (!allowed(instance, &instance->booleans, vr, n, WRITE, &on_demand))
        return wrapper.fmi2SetBoolean(instance->wrapped, vr, n, values);
    for (size_t k = 0; k < n; k++) instance->booleans.values[vr[k]] = values[k] != 0;
    return fmi2OK;
}
