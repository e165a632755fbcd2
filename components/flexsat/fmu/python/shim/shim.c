/* The shim: the library that a host loads. It stands before pythonfmu's wrapper, which lies in the same folder:

   - It passes the wrapper a resource location that the wrapper accepts, whatever valid form of URI the host uses. The
     wrapper (pythonfmu 0.7) cuts off the first seven characters, decodes %20, and aborts when it finds no file there.
   - It logs what is missing, Python or a resource, where the wrapper would end the process.
   - It refuses what the wrapper cannot: another GUID, model exchange, NULL, text that is not UTF-8, states of others. It
     returns fmi2Error for calls that the model refuses, where the wrapper returns fmi2OK (calls.c, states.c).
   - It logs why, whatever log categories the host has switched on (messages.c).
   - It copies Reals and Booleans straight between the host and the buffers of the model where Python would do nothing
     but copy. The wrapper calls Python for each set and get, and builds four objects for each scalar (calls.c).

   Every other call is forwarded, and so is any set or get that must be checked, refused or computed.
   shared_buffers.py defines where the values lie and which may be accessed; it states the same constants. */

#define _GNU_SOURCE
#include "shim.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WRAPPER "libpythonfmu-export.so"
#define MARKER "slavemodule.txt" /* in the resources: the wrapper opens it first of all */

Wrapper wrapper;

/* Where errors are logged. */
typedef struct {
    const fmi2CallbackFunctions *functions;
    fmi2String name;
} Host;

static void log_error(const Host *host, const char *what, const char *detail) {
    log_to_host(host->functions, host->name, fmi2Error, "%s%s", what, detail ? detail : "");
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
    WRAPPED(FIND)
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

/* Return whether a folder holds the marker and the script that it names: without them the wrapper crashes. */
static int holds_resources(const char *folder) {
    char path[2 * PATH_MAX], script[NAME_MAX + 1] = "";
    snprintf(path, sizeof path, "%s/" MARKER, folder);
    FILE *marker = fopen(path, "r");
    if (!marker) return 0;
    int named = fgets(script, sizeof script, marker) != NULL;
    fclose(marker);
    script[strcspn(script, "\r\n")] = '\0';
    snprintf(path, sizeof path, "%s/%s.py", folder, script);
    return named && access(path, R_OK) == 0;
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
    if (!is_utf8(folder)) {
        log_error(host, "the path of the resources is not UTF-8, which Python needs; unpack elsewhere than to ", folder);
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

/* Ask the model where its buffers lie; return 0 if there is no model, which has then logged why. */
static int connect(Instance *instance) {
    const fmi2ValueReference reference = BUFFERS_REFERENCE;
    fmi2String layout = NULL;
    Instance found = *instance;
    instance->control = NULL;
    if (wrapper.fmi2GetString(instance->wrapped, &reference, 1, &layout) != fmi2OK || !layout) return 0;
    Buffer *reals = &found.reals, *booleans = &found.booleans;
    First *first = &found.first;
    if (sscanf(layout, "buffers %127s %zu %p %p %zu %p %p %zu %zu %u %u %u %u %p %p", found.guid, &reals->count,
               (void **)&reals->values, (void **)&reals->access, &booleans->count, (void **)&booleans->values,
               (void **)&booleans->access, &found.integers, &found.strings, &first->reals,
               &first->integers, &first->booleans, &first->strings, (void **)&found.control,
               (void **)&found.now) != 15)
        return 0;
    *instance = found;
    return 1;
}

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }

static int is_blank(fmi2String text) { return !text || !text[strspn(text, " \t\r\n\v\f")]; }

/* Free an instance; the wrapper may not be called after fmi2Fatal, and keeps its part of it. */
static void discard(Instance *instance) {
    free_states(instance);
    if (instance->wrapped && !instance->fatal) wrapper.fmi2FreeInstance(instance->wrapped);
    free(instance->name);
    free(instance);
}

/* Return an instance without a model; the host's name is kept as it is. */
static Instance *allocate(fmi2String name, const fmi2CallbackFunctions *functions, fmi2Boolean logging) {
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance || !(instance->name = strdup(name))) {
        free(instance);
        return NULL;
    }
    if (functions) instance->callbacks = *functions;
    instance->callbacks.logger = log_of_wrapper;
    instance->callbacks.componentEnvironment = instance;
    instance->host = functions;
    instance->logging = logging;
    return instance;
}

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                       const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                       fmi2Boolean logging) {
    const Host host = {functions, name ? name : ""};
    char location[PATH_MAX + 8], *readable;
    if (is_blank(name)) {
        log_error(&host, "fmi2Instantiate: the instance has no name", NULL);
        return NULL;
    }
    if (type != fmi2CoSimulation) {
        log_error(&host, "fmi2Instantiate: this FMU is for co-simulation only", NULL);
        return NULL;
    }
    if (!guid) {
        log_error(&host, "fmi2Instantiate: the GUID is NULL", NULL);
        return NULL;
    }
    if (!locate(&host, resources, location) || !load_wrapper(&host)) return NULL;
    Instance *instance = allocate(name, functions, logging);
    if (!instance || !(readable = copy_as_utf8(name))) {
        if (instance) discard(instance);
        return NULL;
    }
    instance->wrapped =
        wrapper.fmi2Instantiate(readable, type, guid, location, &instance->callbacks, visible, 1 /* messages.c */);
    free(readable);
    if (!instance->wrapped || !connect(instance)) {
        discard(instance);
        return NULL;
    }
    if (strcmp(guid, instance->guid)) {
        log_to_host(functions, name, fmi2Error,
                    "fmi2Instantiate: the GUID %.100s is not that of this FMU, %s; read the model description again",
                    guid, instance->guid);
        discard(instance);
        return NULL;
    }
    return instance;
}

EXPORTED void fmi2FreeInstance(fmi2Component c) {
    if (c) discard(c);
}

EXPORTED fmi2Status fmi2Reset(fmi2Component c) {
    Instance *instance = c;
    if (!instance) return fmi2Error;
    if (instance->fatal) return fmi2Fatal;
    instance->control = NULL; /* the wrapper makes a new object, whose buffers lie elsewhere */
    fmi2Status status = outcome(instance, wrapper.fmi2Reset(instance->wrapped));
    if (status > fmi2Warning) return status;
    return connect(instance) ? fmi2OK : fmi2Error;
}
