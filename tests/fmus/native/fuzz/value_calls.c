/* Calls that read and write values, with right and wrong arguments. */
#include "slots.h"

#include <math.h>
#include <string.h>

enum { MOST = 6 };

static fmi2ValueReference odd_reference(Input *input, Kind kind)
{
    static const fmi2ValueReference wrong[] = {0x7fffffffu, 0x80000000u, 0xffffffffu, 1000000u};
    const fmi2ValueReference count = (fmi2ValueReference)port_table.counts[kind];

    switch (choose(input, 16)) {
    case 0: return wrong[choose(input, 4)];
    case 1: return first_of(kind) + count; /* the first of the next kind, or beyond all */
    case 2: return first_of(kind) - 1;
    default: return count == 0 ? 0 : first_of(kind) + (choose(input, 256) * 256u + choose(input, 256)) % count;
    }
}

/* Choose references; NULL now and then. */
static const fmi2ValueReference *references(Input *input, Kind kind, size_t *n)
{
    static fmi2ValueReference some[MOST];
    size_t k;

    *n = choose(input, MOST);
    for (k = 0; k < *n; k++)
        some[k] = odd_reference(input, kind);
    return choose(input, 32) == 31 ? NULL : some;
}

void get_values(Slot *slot, Input *input)
{
    const Kind kind = (Kind)choose(input, KINDS);
    const unsigned long before = lines;
    double reals[MOST];
    int numbers[MOST];
    fmi2String texts[MOST];
    size_t n, k;
    const fmi2ValueReference *vr = references(input, kind, &n);
    void *const places[KINDS] = {reals, numbers, numbers, texts};
    void *values = choose(input, 32) == 31 ? NULL : places[kind];
    const Answer expected = may_read(slot->model, kind, vr, n, values);
    fmi2Status status;

    for (k = 0; k < MOST; k++)
        reals[k] = 77.0;
    switch (kind) {
    case REAL: status = fmi2GetReal(slot->c, vr, n, values); break;
    case INTEGER: status = fmi2GetInteger(slot->c, vr, n, values); break;
    case BOOLEAN: status = fmi2GetBoolean(slot->c, vr, n, values); break;
    default: status = fmi2GetString(slot->c, vr, n, values);
    }
    judge(slot, "get", status, expected, before);
    for (k = 0; k < n && kind == REAL && values != NULL; k++)
        if (status == fmi2OK ? !isfinite(reals[k]) && slot->model->state != BROKEN : reals[k] != 77.0)
            fail("%.17g was read, status %d", reals[k], (int)status);
}

static void write_some(Slot *slot, Kind kind, const fmi2ValueReference *vr, size_t n, const void *values)
{
    const Answer expected = may_write(slot->model, kind, vr, n, values);
    const unsigned long before = lines;
    fmi2Status status;

    switch (kind) {
    case REAL: status = fmi2SetReal(slot->c, vr, n, values); break;
    case INTEGER: status = fmi2SetInteger(slot->c, vr, n, values); break;
    case BOOLEAN: status = fmi2SetBoolean(slot->c, vr, n, values); break;
    default: status = fmi2SetString(slot->c, vr, n, values);
    }
    if (slot->c != NULL && (status == fmi2OK || expected == EITHER)) /* a tuned value that the model refuses is set */
        write_values(slot->model, kind, vr, n, values);
    judge(slot, "set", status, expected, before);
}

void set_values(Slot *slot, Input *input)
{
    static char longest[TEXT + 1];
    static const char *const odd[] = {"", "toy", "refuse", "two\nlines", NULL, "\xff\xfe", "\xed\xa0\x80", longest};
    const Kind kind = (Kind)choose(input, KINDS);
    double reals[MOST];
    int numbers[MOST];
    fmi2String texts[MOST];
    size_t n, k;
    const fmi2ValueReference *vr = references(input, kind, &n);
    const void *const places[KINDS] = {reals, numbers, numbers, texts};

    memset(longest, 'x', TEXT);
    for (k = 0; k < n; k++) {
        if (kind == REAL)
            reals[k] = odd_number(input);
        else if (kind == STRING)
            texts[k] = odd[choose(input, sizeof odd / sizeof *odd)];
        else {
            const double number = odd_number(input);
            numbers[k] = number > -2e9 && number < 2e9 ? (int)number : 2147483647;
        }
    }
    write_some(slot, kind, vr, n, choose(input, 32) == 31 ? NULL : places[kind]);
}

/* Set all real inputs, as a host does. */
void set_inputs(Slot *slot, Input *input)
{
    static double values[4096];
    const fmi2ValueReference *vr;
    const size_t all = reals_with(INPUT, &vr), n = all < 4096 ? all : 4096;
    const double size = ((double)choose(input, 256) - 128.0) * 1e-3;
    size_t k;

    for (k = 0; k < n; k++)
        values[k] = size * (double)(k % 7);
    write_some(slot, REAL, vr, n, values);
}

void set_nothing(Slot *slot, Input *input) { write_some(slot, (Kind)choose(input, KINDS), NULL, 0, NULL); }

void differentiate_some(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    fmi2ValueReference unknown[MOST], known[MOST];
    const fmi2ValueReference *inputs, *outputs;
    const size_t all_inputs = reals_with(INPUT, &inputs), all_outputs = reals_with(OUTPUT, &outputs);
    double seed[MOST], found[MOST];
    const size_t unknowns = choose(input, MOST), knowns = choose(input, MOST);
    const int right = choose(input, 4) != 0 && all_inputs > 0 && all_outputs > 0;
    double *place = choose(input, 32) == 31 ? NULL : found;
    Answer expected;
    fmi2Status status;
    size_t k;

    for (k = 0; k < MOST; k++) {
        found[k] = 77.0;
        unknown[k] = right ? outputs[choose(input, 256) % all_outputs] : odd_reference(input, REAL);
        known[k] = right ? inputs[choose(input, 256) % all_inputs] : odd_reference(input, REAL);
        seed[k] = odd_number(input);
    }
    expected = may_differentiate(slot->model, unknown, unknowns, known, knowns, seed, place);
    status = fmi2GetDirectionalDerivative(slot->c, unknown, unknowns, known, knowns, seed, place);
    judge(slot, "directional derivative", status, expected, before);
    for (k = 0; k < unknowns && place != NULL; k++)
        if (status == fmi2OK ? !isfinite(found[k]) : found[k] != 77.0)
            fail("the derivative is %.17g, status %d", found[k], (int)status);
        else if (status == fmi2OK && !(ports[port_of_reference[unknown[k]]].flags & FOLLOWS_INPUTS) && found[k] != 0.0)
            fail("the derivative of an output that follows no input is %.17g", found[k]);
}

/* Functions that no FMU of flexsat has. */
void other_values(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    const fmi2ValueReference reference = 0;
    const fmi2Integer order = 1;
    double value = 0.0;

    judge(slot, "derivatives of inputs or outputs",
          choose(input, 2) ? fmi2SetRealInputDerivatives(slot->c, &reference, 1, &order, &value)
                           : fmi2GetRealOutputDerivatives(slot->c, NULL, choose(input, 2), NULL, NULL),
          ERROR_ONLY, before);
}
