/* Calls that save, restore and serialise states, with right and wrong arguments. */
#include "slots.h"

#include <stdlib.h>
#include <string.h>

static Handle *some_handle(Slot *slot, Input *input) { return &slot->handles[choose(input, HANDLES)]; }

void save_state(Slot *slot, Input *input)
{
    Handle *handle = some_handle(slot, input);
    const fmi2FMUstate old = handle->state;
    const unsigned long before = lines;
    const fmi2Status status = fmi2GetFMUstate(slot->c, &handle->state);

    judge(slot, "save", status, OK_ONLY, before);
    if (status == fmi2OK) {
        if (handle->state == NULL || (old != NULL && handle->state != old))
            fail("saving did not use the state that it was given");
        copy_model(slot->model, handle->model);
    } else if (handle->state != old)
        fail("a refused call changed the pointer to a state");
}

void restore_state(Slot *slot, Input *input)
{
    const Handle *handle = some_handle(slot, input);
    const unsigned long before = lines;
    Model *model = slot->model;
    const int ends = model->ends;
    const double stop = model->stop;
    uint8_t *once = NULL, *again = NULL;
    const fmi2Status status = fmi2SetFMUstate(slot->c, handle->state);
    fmi2FMUstate copy;
    size_t size;

    judge(slot, "restore", status, handle->state != NULL ? OK_ONLY : ERROR_ONLY, before);
    if (status != fmi2OK)
        return;
    copy_model(handle->model, model);
    model->ends = ends; /* the stop time is that of the last experiment */
    model->stop = stop;
    copy = keep(slot);
    size = serialised(slot, copy, &again);
    if (serialised(slot, handle->state, &once) != size || memcmp(once, again, size) != 0)
        fail("what was restored is not what was saved");
    free(once), free(again);
    if (fmi2FreeFMUstate(slot->c, &copy) != fmi2OK)
        fail("a state cannot be freed");
    compare(slot->c, model);
}

void free_one_state(Slot *slot, Input *input)
{
    Handle *handle = some_handle(slot, input);
    const unsigned long before = lines;

    if (choose(input, 16) == 15) {
        judge(slot, "free at NULL", fmi2FreeFMUstate(slot->c, NULL), OK_ONLY, before);
        return;
    }
    judge(slot, "free a state", fmi2FreeFMUstate(slot->c, &handle->state), OK_ONLY, before);
    if (slot->c != NULL && handle->state != NULL)
        fail("freeing left the pointer");
}

void serialise_state(Slot *slot, Input *input)
{
    const Handle *handle = some_handle(slot, input);
    Saved *to = &saved[choose(input, SAVED)];
    uint8_t few[16];
    size_t size = 0;
    unsigned long before = lines;
    fmi2Status status;

    if (handle->state != NULL && slot->c != NULL && choose(input, 8) != 7) {
        to->size = serialised(slot, handle->state, &to->bytes);
        copy_model(handle->model, to->model);
        count_call(fmi2OK);
        if (lines != before)
            fail("serialising logged a line");
        return;
    }
    switch (choose(input, 3)) {
    case 0: status = fmi2SerializedFMUstateSize(slot->c, handle->state, NULL); break;
    case 1: status = fmi2SerializeFMUstate(slot->c, handle->state, NULL, 16); break;
    default: status = fmi2SerializeFMUstate(slot->c, handle->state, (fmi2Byte *)few, sizeof few);
    }
    judge(slot, "serialise wrongly", status, ERROR_ONLY, before);
    before = lines;
    status = fmi2SerializedFMUstateSize(slot->c, handle->state, &size);
    judge(slot, "size", status, handle->state != NULL ? OK_ONLY : ERROR_ONLY, before);
}

/* Bytes of any instance of the FMU are accepted; damaged ones, and those cut short, are not. */
void deserialise_state(Slot *slot, Input *input)
{
    const Saved *from = &saved[choose(input, SAVED)];
    Handle *handle = some_handle(slot, input);
    const unsigned long before = lines;
    const unsigned way = choose(input, 8);
    fmi2FMUstate made = NULL;
    uint8_t *bytes;
    size_t size = from->size;
    fmi2Status status;

    if (slot->c == NULL || handle->state != NULL)
        return;
    if (size == 0 || way == 7) {
        status = fmi2DeSerializeFMUstate(slot->c, way & 1 ? NULL : (const fmi2Byte *)"nonsense, but some bytes of it",
                                         size == 0 ? choose(input, 31) : 30, way & 2 ? &made : NULL);
        judge(slot, "deserialise nonsense", status, ERROR_ONLY, before);
        return;
    }
    bytes = malloc(size + 1);
    memcpy(bytes, from->bytes, size);
    bytes[size] = 0;
    if (way == 5)
        bytes[(choose(input, 256) * 256u + choose(input, 256)) % size] ^= (uint8_t)(1u << choose(input, 8));
    if (way == 6)
        size = choose(input, 2) ? size + 1 : (choose(input, 256) * 256u + choose(input, 256)) % size;
    status = fmi2DeSerializeFMUstate(slot->c, (const fmi2Byte *)bytes, size, &made);
    free(bytes);
    judge(slot, "deserialise", status, way < 5 ? OK_ONLY : ERROR_ONLY, before);
    if ((status == fmi2OK) != (made != NULL))
        fail("deserialising returned %d and %s", (int)status, made != NULL ? "a state" : "none");
    handle->state = made;
    copy_model(from->model, handle->model);
}

/* States of the other instance, freed ones, and pointers to anything. */
void wrong_state(Slot *slot, Input *input)
{
    static uint8_t anything[64];
    const Slot *other = slot == slots ? &slots[1] : slots;
    const unsigned which = choose(input, 4), call = choose(input, 5);
    const unsigned long before = lines;
    fmi2FMUstate state = anything, kept;
    uint8_t bytes[64];
    size_t size = 0;
    fmi2Status status;

    if (slot->c == NULL)
        return;
    if (which == 1)
        state = other->handles[choose(input, HANDLES)].state;
    if (which == 2) { /* its address is no longer that of a state */
        state = keep(slot);
        kept = state;
        if (fmi2FreeFMUstate(slot->c, &kept) != fmi2OK)
            fail("a state cannot be freed");
    }
    if (which == 3)
        state = (fmi2FMUstate)slot->c;
    if (state == NULL && (call == 0 || call == 4))
        return; /* is allowed */
    kept = state;
    switch (call) {
    case 0: status = fmi2GetFMUstate(slot->c, &kept); break;
    case 1: status = fmi2SetFMUstate(slot->c, state); break;
    case 2: status = fmi2SerializedFMUstateSize(slot->c, state, &size); break;
    case 3: status = fmi2SerializeFMUstate(slot->c, state, (fmi2Byte *)bytes, sizeof bytes); break;
    default: status = fmi2FreeFMUstate(slot->c, &kept);
    }
    judge(slot, "use a wrong state", status, ERROR_ONLY, before);
    if (kept != state)
        fail("a refused call changed the pointer to a state");
}
