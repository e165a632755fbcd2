#include "slots.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

Slot slots[SLOTS];
Saved saved[SAVED];

static unsigned long calls[4], steps;

static void print_counts(void)
{
    fprintf(stderr, "calls: %lu OK, %lu warnings, %lu discarded, %lu refused; %lu steps\n", calls[fmi2OK],
            calls[fmi2Warning], calls[fmi2Discard], calls[fmi2Error], steps);
}

void count_call(fmi2Status status) { calls[(int)status & 3]++; }

void count_step(void) { steps++; }

void make_slots(void)
{
    int i, k;

    for (i = 0; i < SLOTS; i++) {
        slots[i].model = make_model();
        for (k = 0; k < HANDLES; k++)
            slots[i].handles[k].model = make_model();
    }
    for (i = 0; i < SAVED; i++)
        saved[i].model = make_model();
    atexit(print_counts);
}

void start_small(Slot *slot)
{
    const int few = 3;
    Input none = {NULL, 0};
    fmi2ValueReference reference;
    int k;

    for (k = 0; k < port_table.ports; k++)
        if (strcmp(ports[k].name, "modes") == 0) {
            reference = first_of(ports[k].kind) + (fmi2ValueReference)ports[k].first;
            if (fmi2SetInteger(slot->c, &reference, 1, &few) != fmi2OK)
                fail("modes cannot be set");
            slot->model->integer[ports[k].first] = few;
        }
    setup(slot, &none);
    enter(slot, &none);
    leave(slot, &none);
}

void empty_slot(Slot *slot)
{
    int k;

    if (slot->c != NULL)
        fmi2FreeInstance(slot->c); /* with its states */
    slot->c = NULL;
    for (k = 0; k < HANDLES; k++)
        slot->handles[k].state = NULL;
}

void judge(Slot *slot, const char *call, fmi2Status status, Answer expected, unsigned long before)
{
    const unsigned long logged = lines - before;

    if (status != fmi2OK && status != fmi2Error)
        fail("%s returned %d", call, (int)status);
    count_call(status);
    if (slot->c == NULL) {
        if (status != fmi2Error || logged != 0)
            fail("%s without an instance returned %d and logged %lu lines", call, (int)status, logged);
        return;
    }
    if (expected == ERROR_ONLY && status == fmi2OK)
        fail("%s has to be refused, and returned OK", call);
    if (expected == OK_ONLY && status == fmi2Error && memory_left < 0)
        fail("%s is allowed, and was refused", call);
    if (logged != (status == fmi2OK ? 0 : 1))
        fail("%s returned %d and logged %lu lines", call, (int)status, logged);
    if (status == fmi2Error) {
        slot->model->state = BROKEN;
        compare(slot->c, slot->model);
    }
}

fmi2FMUstate keep(Slot *slot)
{
    const long left = memory_left;
    fmi2FMUstate state = NULL;

    memory_left = -1;
    if (fmi2GetFMUstate(slot->c, &state) != fmi2OK)
        fail("a state cannot be saved");
    memory_left = left;
    return state;
}

size_t serialised(Slot *slot, fmi2FMUstate state, uint8_t **bytes)
{
    size_t size = 0;

    if (fmi2SerializedFMUstateSize(slot->c, state, &size) != fmi2OK)
        fail("a state has no size");
    *bytes = realloc(*bytes, size);
    if (fmi2SerializeFMUstate(slot->c, state, (fmi2Byte *)*bytes, size) != fmi2OK)
        fail("a state cannot be serialised");
    return size;
}
