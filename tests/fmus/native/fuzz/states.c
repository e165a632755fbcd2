/* Serialised states with changed bytes, with and without a digest that fits: refused, or a state that can be used. */
#include "slots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifndef STEP
#define STEP 0.01
#endif
#ifndef BASE_STEPS
#define BASE_STEPS 40 /* of the state that is longest in the run */
#endif

enum { BASES = 6, MOST_CHANGES = 8 };

static struct {
    uint8_t *bytes;
    size_t size;
} bases[BASES];
static fmi2FMUstate base;   /* of the running instance */
static unsigned long seen; /* lines of checked calls */

static void add_base(int which, Slot *slot)
{
    fmi2FMUstate state = keep(slot);

    bases[which].size = serialised(slot, state, &bases[which].bytes);
    if (fmi2FreeFMUstate(slot->c, &state) != fmi2OK)
        fail("a state cannot be freed");
}

static void prepare(void)
{
    Slot *slot = &slots[0];
    Input none = {NULL, 0};
    int k;

    make_slots();
    instance_again(slot, &none);
    add_base(0, slot);
    start_small(slot);
    add_base(1, slot);
    do_right_step(slot, &none);
    add_base(2, slot);
    for (k = 1; k < BASE_STEPS; k++) {
        const uint8_t size = (uint8_t)(90 + k % 70);
        Input input = {&size, 1};
        set_inputs(slot, &input);
        do_right_step(slot, &none);
    }
    add_base(3, slot);
    base = keep(slot);
    end(slot, &none);
    add_base(4, slot);
    never(slot, &none);
    add_base(5, slot);
}

static void change(uint8_t *bytes, size_t *size, Input *input)
{
    static const int32_t odd[] = {0, 1, -1, 2, 5, 127, 2147483647, -2147483647 - 1, 65536, 1000000};
    const unsigned way = choose(input, 16);
    const size_t place = (choose(input, 256) * 256u + choose(input, 256)) % *size;
    double number;

    if (way < 5)
        bytes[place] ^= (uint8_t)(1u << choose(input, 8));
    else if (way < 8)
        bytes[place] = (uint8_t)choose(input, 256);
    else if (way < 12 && place / 8 * 8 + 8 <= *size) {
        number = odd_number(input);
        memcpy(bytes + place / 8 * 8, &number, sizeof number);
    } else if (way < 15 && place / 4 * 4 + 4 <= *size)
        memcpy(bytes + place / 4 * 4, &odd[choose(input, 10)], sizeof odd[0]);
    else if (way == 15 && choose(input, 4) == 3)
        *size = place;
}

/* Return the status, after a check that an error was logged once since the last check, and nothing else. */
static fmi2Status checked(const char *call, fmi2Status status)
{
    if ((status != fmi2OK && status != fmi2Error) || lines - seen != (status == fmi2Error))
        fail("%s returned %d and logged %lu lines", call, (int)status, lines - seen);
    seen = lines;
    count_call(status);
    return status;
}

/* Read all real outputs: finite, or refused. */
static void read_outputs(fmi2Component c)
{
    static double values[4096];
    const fmi2ValueReference *vr;
    const size_t all = reals_with(OUTPUT, &vr), n = all < 4096 ? all : 4096;
    size_t k;

    if (checked("get", fmi2GetReal(c, vr, n, values)) != fmi2OK)
        return;
    for (k = 0; k < n; k++)
        if (!isfinite(values[k]))
            fail("real output %u is %g", vr[k], values[k]);
}

/* Use what was restored, as a host goes on with it. */
static void use(fmi2Component c, Input *input)
{
    static double values[4096];
    const fmi2ValueReference *inputs;
    const size_t all = reals_with(INPUT, &inputs), n = all < 4096 ? all : 4096;
    fmi2FMUstate state = NULL;
    double present = 0.0;
    unsigned k, steps = 1 + choose(input, 6);
    const int running = checked("inquire", fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &present)) == fmi2OK;

    if (checked("save", fmi2GetFMUstate(c, &state)) == fmi2OK && fmi2FreeFMUstate(c, &state) != fmi2OK)
        fail("a state cannot be freed");
    if (!running) { /* or the state was that of a failed instance */
        checked("enter", fmi2EnterInitializationMode(c));
        return;
    }
    read_outputs(c);
    for (k = 0; k < steps; k++, present += STEP)
        if (checked("step", fmi2DoStep(c, present, STEP, 1)) == fmi2OK) {
            count_step();
            read_outputs(c);
            checked("set", fmi2SetReal(c, inputs, n, values));
        }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t count)
{
    Input input = {data, count};
    Slot *slot = &slots[0];
    uint8_t *bytes;
    size_t size;
    unsigned which, changes, fits, k;
    int same;
    fmi2FMUstate state = NULL;
    fmi2Status status;

    if (base == NULL)
        prepare();
    seen = lines;
    which = choose(&input, BASES);
    changes = choose(&input, MOST_CHANGES);
    fits = choose(&input, 8);
    size = bases[which].size;
    bytes = malloc(size);
    memcpy(bytes, bases[which].bytes, size);
    size -= 8;
    for (k = 0; k < changes && size > 0; k++)
        change(bytes, &size, &input);
    if (fits != 7)
        digest(bytes, size, bytes + size);
    size += 8;
    same = size == bases[which].size && memcmp(bytes, bases[which].bytes, size) == 0;
    status = checked("deserialise", fmi2DeSerializeFMUstate(slot->c, (const fmi2Byte *)bytes, size, &state));
    free(bytes);
    if (same ? status != fmi2OK : fits == 7 && status == fmi2OK)
        fail("deserialising %s bytes returned %d", same ? "right" : "damaged", (int)status);
    if ((status == fmi2OK) != (state != NULL))
        fail("deserialising returned %d and %s", (int)status, state != NULL ? "a state" : "none");
    if (status == fmi2OK && checked("restore", fmi2SetFMUstate(slot->c, state)) == fmi2OK)
        use(slot->c, &input);
    if (state != NULL && checked("free", fmi2FreeFMUstate(slot->c, &state)) != fmi2OK)
        fail("a state cannot be freed");
    if (checked("return", fmi2SetFMUstate(slot->c, base)) != fmi2OK)
        fail("the instance cannot go back");
    return 0;
}
