/* Two instances, each with its model and its states, and bytes of states that go from one to the other. */
#ifndef FUZZ_SLOTS_H
#define FUZZ_SLOTS_H

#include "model.h"

enum { SLOTS = 2, HANDLES = 4, SAVED = 4 };

typedef struct Handle {
    fmi2FMUstate state; /* NULL: none */
    Model *model;       /* of the instance when it was saved */
} Handle;

typedef struct Slot {
    fmi2Component c; /* NULL: none */
    Model *model;
    Handle handles[HANDLES];
} Slot;

typedef struct Saved {
    uint8_t *bytes;
    size_t size; /* 0: none */
    Model *model;
} Saved;

extern Slot slots[SLOTS];
extern Saved saved[SAVED];

/* Check what a call returned, with the lines that it logged since `before`, and follow it in the model. */
void judge(Slot *slot, const char *call, fmi2Status status, Answer expected, unsigned long before);

/* What a check of the host itself needs: calls that have to succeed, with any memory. */
fmi2FMUstate keep(Slot *slot);
size_t serialised(Slot *slot, fmi2FMUstate state, uint8_t **bytes); /* grows the array */

/* The numbers of calls, by their results; printed at the end of the process. */
void count_call(fmi2Status status);
void count_step(void);

void make_slots(void);
/* Start a new instance with few modes, if it has a parameter for that: it starts in no time then. */
void start_small(Slot *slot);
void empty_slot(Slot *slot); /* free its states and instance */

/* states_calls.c, value_calls.c, life_calls.c: one call of the kind, with arguments from the input */
typedef void Action(Slot *slot, Input *input);
Action get_values, set_values, set_inputs, set_nothing, differentiate_some, other_values;
Action setup, enter, leave, do_step, do_right_step, end, reset, instance_again, log_choice, inquire, never;
Action save_state, restore_state, free_one_state, serialise_state, deserialise_state, wrong_state;

#endif
