/* Default bodies of the FMI functions that an FMU of the tests does not define, shared by FMI 2.0 and 3.0.

   fmi2_defaults.c and fmi3_defaults.c give these bodies to all functions, as weak symbols: linked with an FMU, they stand where
   it has no function of its own. To the library a status is an int and a handle a pointer, whatever the version. */

#include <stdlib.h>
#include <string.h>

enum { OK = 0, ERROR = 3 }; /* of fmi2Status and fmi3Status */

#define WEAK __attribute__((weak))
#define HOOK __attribute__((weak, visibility("hidden"))) /* for the FMU alone, not for who loads it */

/* The result of a function that is not implemented. An FMU that logs defines this hook. */
HOOK int refused(void *instance) { (void)instance; return ERROR; }

/* The bytes at the beginning of an instance that are its state. An FMU that can save it defines this.
   Not const: gcc believes the initial value of a constant, weak or not. */
HOOK size_t state_size = 0;

static int accept_all(void) { return OK; }
static int refuse(void *instance) { return refused(instance); }

static int no_values(void *instance, const void *references, size_t count) {
    (void)references;
    return count ? refused(instance) : OK;
}

static int get_state(void *instance, void **state) {
    if (!state_size) return refused(instance);
    if (!*state) *state = malloc(state_size);
    memcpy(*state, instance, state_size);
    return OK;
}

static int set_state(void *instance, const void *state) {
    if (!state_size) return refused(instance);
    memcpy(instance, state, state_size);
    return OK;
}

static int free_state(void *instance, void **state) {
    if (!state_size) return refused(instance);
    free(*state);
    *state = NULL;
    return OK;
}

static int measure_state(void *instance, const void *state, size_t *size) {
    (void)state;
    if (!state_size) return refused(instance);
    *size = state_size;
    return OK;
}

static int serialise_state(void *instance, const void *state, char *bytes, size_t size) {
    if (!state_size || size < state_size) return refused(instance);
    memcpy(bytes, state, state_size);
    return OK;
}

static int deserialise_state(void *instance, const char *bytes, size_t size, void **state) {
    if (!state_size || size != state_size) return refused(instance);
    if (!*state) *state = malloc(state_size);
    memcpy(*state, bytes, state_size);
    return OK;
}

#pragma GCC diagnostic ignored "-Wattribute-alias" /* one body has many types */
