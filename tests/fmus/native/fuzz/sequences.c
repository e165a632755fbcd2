/* Sequences of FMI calls, legal and illegal, on two instances, made from the fuzzer's bytes and compared with the model.

Where an instance takes long to start (COSTLY), the first one is kept: a sequence begins with its state after the first
steps, and what makes it start again is rare. */
#include "slots.h"

#include <stdlib.h>
#include <string.h>

#ifndef COSTLY
#define COSTLY 0
#endif

enum { LONGEST = 120 }; /* calls */

static Action *const actions[] = {
    setup, enter, leave, setup, enter, leave, do_right_step, do_right_step, do_right_step, do_right_step, do_right_step,
    do_step, do_step, get_values, get_values, get_values, set_values, set_values, set_values, set_inputs, set_inputs,
    set_nothing, differentiate_some, differentiate_some, other_values, end, reset, instance_again, log_choice, inquire,
    inquire, never, save_state, save_state, save_state, restore_state, restore_state, restore_state, free_one_state,
    serialise_state, serialise_state, deserialise_state, deserialise_state, wrong_state,
};

static fmi2FMUstate base;
static Model *base_model;

static void begin_kept(void)
{
    Slot *slot = &slots[0];
    Input none = {NULL, 0};
    int k;

    if (base == NULL) {
        instance_again(slot, &none);
        start_small(slot);
        for (k = 0; k < 30; k++)
            do_right_step(slot, &none);
        if (slot->model->state != RUNNING)
            fail("the instance does not start");
        base = keep(slot);
        base_model = make_model();
        copy_model(slot->model, base_model);
    }
    if (fmi2SetFMUstate(slot->c, base) != fmi2OK)
        fail("the instance cannot go back");
    copy_model(base_model, slot->model);
}

/* Free all but the kept instance. */
static void end_sequence(void)
{
    int k;

    memory_left = -1;
    empty_slot(&slots[1]);
    if (!COSTLY)
        empty_slot(&slots[0]);
    for (k = 0; k < HANDLES && COSTLY; k++)
        if (slots[0].handles[k].state != NULL && fmi2FreeFMUstate(slots[0].c, &slots[0].handles[k].state) != fmi2OK)
            fail("a state cannot be freed");
    for (k = 0; k < SAVED; k++) {
        free(saved[k].bytes);
        saved[k].bytes = NULL;
        saved[k].size = 0;
    }
    if (!COSTLY && blocks != 0)
        fail("%ld blocks of memory were not freed", blocks);
}

/* Make a call; if it is refused, go back to the state before, which has to be the same in every byte. */
static void make_guarded(Slot *slot, Action *action, Input *input)
{
    static Model *model;
    const State state = slot->model->state;
    fmi2FMUstate kept = keep(slot), again;
    uint8_t *before = NULL, *after = NULL;
    const fmi2Component c = slot->c;
    const int ends = slot->model->ends;
    const double stop = slot->model->stop;
    size_t size = serialised(slot, kept, &before);

    if (model == NULL)
        model = make_model();
    copy_model(slot->model, model);
    action(slot, input);
    if (slot->c != c) { /* freed, and its states with it */
        free(before);
        return;
    }
    if (slot->model->state == BROKEN && state != BROKEN) {
        memory_left = -1;
        if (fmi2SetFMUstate(slot->c, kept) != fmi2OK)
            fail("a refused instance cannot go back");
        copy_model(model, slot->model);
        slot->model->ends = ends;
        slot->model->stop = stop;
        again = keep(slot);
        if (serialised(slot, again, &after) != size || memcmp(before, after, size) != 0)
            fail("an instance that went back after a refused call is another");
        compare(slot->c, slot->model);
        if (fmi2FreeFMUstate(slot->c, &again) != fmi2OK)
            fail("a state cannot be freed");
    }
    if (fmi2FreeFMUstate(slot->c, &kept) != fmi2OK)
        fail("a state cannot be freed");
    free(before), free(after);
}

/* Make an instance, and bring it to a state that the input chooses. */
static void begin_new(Slot *slot, Input *input)
{
    const unsigned way = choose(input, 6);
    Input none = {NULL, 0};

    instance_again(slot, &none);
    if (way > 0)
        setup(slot, input);
    if (way > 1)
        enter(slot, &none);
    if (way > 2)
        leave(slot, &none);
    if (way > 3)
        do_right_step(slot, input);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    Input input = {bytes, size};
    int k;

    if (slots[0].model == NULL)
        make_slots();
    if (COSTLY)
        begin_kept();
    else
        begin_new(&slots[0], &input);
    for (k = 0; k < LONGEST && input.left > 0; k++) {
        const unsigned how = choose(&input, 256);
        Slot *slot = &slots[how / 4 % 8 == 7];
        Action *action = actions[choose(&input, sizeof actions / sizeof *actions)];
        const int starts = action == instance_again || action == reset || action == leave;
        if (COSTLY && ((starts && choose(&input, 32) != 31) || (slot->c == slots[0].c && action == instance_again)))
            continue;
        if (slot->c == NULL && how / 32 < 7)
            action = instance_again; /* without an instance there is little to see */
        if (COSTLY && slot == &slots[1] && slot->c == NULL && choose(&input, 32) != 31)
            continue;
        if (how >= 252)
            memory_left = choose(&input, 24);
        else if (how >= 200)
            memory_left = -1;
        if (how % 4 != 3 && slot->c != NULL)
            make_guarded(slot, action, &input);
        else
            action(slot, &input);
    }
    end_sequence();
    return 0;
}
