/* Saved states. The wrapper's are objects of Python that it uses without a look: a host gets the address of an entry in
   a list of its instance, and only what is in that list is used. */

#include "shim.h"

#include <stdlib.h>

#define BEGIN                                                                                                          \
    Instance *instance = c;                                                                                            \
    fmi2Status status = begin(instance);                                                                               \
    if (status != fmi2OK) return status

static State *known(const Instance *instance, fmi2FMUstate state) {
    for (State *each = instance->states; each; each = each->next)
        if (each == state) return each;
    return NULL;
}

static fmi2Status refuse_state(Instance *instance, const char *call, fmi2FMUstate state) {
    return refuse(instance, "%s: %s", call,
                  state ? "no state of this instance: freed, or of another one" : "the state is NULL");
}

/* Keep an object of the wrapper in `state`, or in a new entry if that is NULL. */
static State *keep(Instance *instance, State *state, fmi2FMUstate wrapped) {
    size_t size;
    if (wrapper.fmi2SerializedFMUstateSize(instance->wrapped, wrapped, &size) != fmi2OK) return NULL;
    if (!state) {
        state = calloc(1, sizeof *state);
        if (!state) return NULL;
        state->next = instance->states;
        instance->states = state;
    } else {
        wrapper.fmi2FreeFMUstate(instance->wrapped, &state->wrapped);
    }
    state->wrapped = wrapped;
    state->size = size;
    return state;
}

/* Keep a new object, or free it if the call that made it failed. */
static fmi2Status finish(Instance *instance, const char *call, fmi2Status status, State *old, fmi2FMUstate wrapped,
                         fmi2FMUstate *state) {
    State *kept = status <= fmi2Warning ? keep(instance, old, wrapped) : NULL;
    if (kept) {
        *state = kept;
        return status;
    }
    if (wrapped && !instance->fatal) wrapper.fmi2FreeFMUstate(instance->wrapped, &wrapped);
    return status <= fmi2Warning ? refuse(instance, "%s: no memory for the state", call) : status;
}

void free_states(Instance *instance) {
    while (instance->states) {
        State *first = instance->states;
        instance->states = first->next;
        if (!instance->fatal) wrapper.fmi2FreeFMUstate(instance->wrapped, &first->wrapped);
        free(first);
    }
}

EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    BEGIN;
    if (!state) return refuse(instance, "getFMUstate: the state goes to a NULL pointer");
    State *old = known(instance, *state);
    if (*state && !old) return refuse_state(instance, "getFMUstate", *state);
    fmi2FMUstate wrapped = NULL;
    status = outcome(instance, wrapper.fmi2GetFMUstate(instance->wrapped, &wrapped));
    return finish(instance, "getFMUstate", status, old, wrapped, state);
}

EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    BEGIN;
    const State *given = known(instance, state);
    if (!given) return refuse_state(instance, "setFMUstate", state);
    return outcome(instance, wrapper.fmi2SetFMUstate(instance->wrapped, given->wrapped));
}

EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    BEGIN;
    if (!state || !*state) return fmi2OK; /* as the standard says */
    State *given = known(instance, *state), **link = &instance->states;
    if (!given) return refuse_state(instance, "freeFMUstate", *state);
    while (*link != given) link = &(*link)->next;
    *link = given->next;
    status = wrapper.fmi2FreeFMUstate(instance->wrapped, &given->wrapped);
    free(given);
    *state = NULL;
    return outcome(instance, status);
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    BEGIN;
    const State *given = known(instance, state);
    if (!given) return refuse_state(instance, "serializedFMUstateSize", state);
    if (!size) return refuse(instance, "serializedFMUstateSize: the size goes to a NULL pointer");
    *size = given->size;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    BEGIN;
    const State *given = known(instance, state);
    if (!given) return refuse_state(instance, "serializeFMUstate", state);
    if (!bytes) return refuse(instance, "serializeFMUstate: the bytes go to a NULL array");
    if (size != given->size)
        return refuse(instance, "serializeFMUstate: the state has %zu bytes, not %zu", given->size, size);
    return outcome(instance, wrapper.fmi2SerializeFMUstate(instance->wrapped, given->wrapped, bytes, size));
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                            fmi2FMUstate *state) {
    BEGIN;
    if (!bytes) return refuse(instance, "deSerializeFMUstate: the bytes come from a NULL array");
    if (!state) return refuse(instance, "deSerializeFMUstate: the state goes to a NULL pointer");
    fmi2FMUstate wrapped = NULL;
    status = outcome(instance, wrapper.fmi2DeSerializeFMUstate(instance->wrapped, bytes, size, &wrapped));
    if (status <= fmi2Warning) {
        instance->control->checking = 1;
        status = outcome(instance, wrapper.fmi2SetFMUstate(instance->wrapped, wrapped));
        instance->control->checking = 0;
    }
    return finish(instance, "deSerializeFMUstate", status, NULL, wrapped, state);
}
