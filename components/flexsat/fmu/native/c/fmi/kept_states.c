/* Saved states. A host gets the address of an entry in a list of its instance, and only what is in that list is
used. */
#include "instance.h"

#include <stdio.h>
#include <string.h>

static State *known(const Instance *instance, const void *state)
{
    State *each = instance->states;

    while (each != NULL && each != state)
        each = each->next;
    return each;
}

static Status refuse_state(Instance *instance, const char *call, const void *state)
{
    return refuse_call(instance, call, "%s",
                       state != NULL ? "no state of this instance: freed, or of another one" : "the state is NULL");
}

/* Make room for a state of `size` bytes, in a new entry if `state` is NULL; NULL if there is no memory. */
static State *reserve(Instance *instance, State *state, size_t size)
{
    const Memory *memory = &instance->memory;
    State *entry = state != NULL ? state : memory->allocate(1, sizeof *entry);
    unsigned char *bytes;

    if (entry == NULL || (state != NULL && state->size == size))
        return entry;
    bytes = memory->allocate(1, size);
    if (bytes == NULL) {
        if (state == NULL)
            memory->release(entry);
        return NULL;
    }
    if (state != NULL)
        memory->release(state->bytes);
    else {
        entry->next = instance->states;
        instance->states = entry;
    }
    entry->bytes = bytes;
    entry->size = size;
    return entry;
}

static void forget(Instance *instance, State *state)
{
    State **link = &instance->states;

    while (*link != state)
        link = &(*link)->next;
    *link = state->next;
    instance->memory.release(state->bytes);
    instance->memory.release(state);
}

void free_states(Instance *instance)
{
    while (instance->states != NULL)
        forget(instance, instance->states);
}

Status keep_state(Instance *instance, const char *call, void **state)
{
    State *old;

    if (state == NULL)
        return refuse_call(instance, call, "the state goes to a NULL pointer");
    old = known(instance, *state);
    if (*state != NULL && old == NULL)
        return refuse_state(instance, call, *state);
    old = reserve(instance, old, saved_size(instance));
    if (old == NULL)
        return refuse_call(instance, call, "there is no memory for the state");
    save(instance, old->bytes);
    *state = old;
    return CALL_OK;
}

Status restore_kept(Instance *instance, const char *call, const void *state)
{
    const State *given = known(instance, state);
    char reason[REASON_SIZE];
    int model;

    if (given == NULL)
        return refuse_state(instance, call, state);
    if (restore(instance, given->bytes, given->size, reason, &model))
        return CALL_OK;
    if (model)
        instance->started = 0;
    return refuse_call(instance, call, "%s", reason);
}

Status free_state(Instance *instance, const char *call, void **state)
{
    if (state == NULL || *state == NULL)
        return CALL_OK; /* as the standard says */
    if (known(instance, *state) == NULL)
        return refuse_state(instance, call, *state);
    forget(instance, *state);
    *state = NULL;
    return CALL_OK;
}

Status serialised_size(Instance *instance, const char *call, const void *state, size_t *size)
{
    const State *given = known(instance, state);

    if (given == NULL)
        return refuse_state(instance, call, state);
    if (size == NULL)
        return refuse_call(instance, call, "the size goes to a NULL pointer");
    *size = given->size + DIGEST_SIZE;
    return CALL_OK;
}

Status serialise(Instance *instance, const char *call, const void *state, unsigned char bytes[], size_t size)
{
    const State *given = known(instance, state);
    unsigned char digest[DIGEST_SIZE];

    if (given == NULL)
        return refuse_state(instance, call, state);
    if (bytes == NULL)
        return refuse_call(instance, call, "the bytes go to a NULL array");
    if (size != given->size + DIGEST_SIZE)
        return refuse_call(instance, call, "the state has %lu bytes, not %lu",
                           (unsigned long)(given->size + DIGEST_SIZE), (unsigned long)size);
    digest_of(given->bytes, given->size, digest);
    memcpy(bytes, given->bytes, given->size);
    memcpy(bytes + given->size, digest, DIGEST_SIZE);
    return CALL_OK;
}

Status deserialise(Instance *instance, const char *call, const unsigned char bytes[], size_t size, void **state)
{
    State *made;
    char reason[REASON_SIZE];
    unsigned char digest[DIGEST_SIZE];

    if (bytes == NULL)
        return refuse_call(instance, call, "the bytes come from a NULL array");
    if (state == NULL)
        return refuse_call(instance, call, "the state goes to a NULL pointer");
    if (size > DIGEST_SIZE)
        digest_of(bytes, size - DIGEST_SIZE, digest);
    if (size <= DIGEST_SIZE || memcmp(digest, bytes + size - DIGEST_SIZE, DIGEST_SIZE) != 0)
        return refuse_call(instance, call, "these bytes are not a saved state of this component: cut short, or"
                                           " changed since they were saved");
    if (!is_saved_state(bytes, size - DIGEST_SIZE, reason))
        return refuse_call(instance, call, "%s", reason);
    made = reserve(instance, NULL, size - DIGEST_SIZE);
    if (made == NULL)
        return refuse_call(instance, call, "there is no memory for the state");
    memcpy(made->bytes, bytes, made->size);
    *state = made;
    return CALL_OK;
}
