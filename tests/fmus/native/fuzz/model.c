#include "model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const Port *port_of(fmi2ValueReference reference) { return &ports[port_of_reference[reference]]; }

Model *make_model(void)
{
    Model *model = calloc(1, sizeof *model);

    model->real = calloc((size_t)port_table.counts[REAL] + 1, sizeof(double));
    model->integer = calloc((size_t)port_table.counts[INTEGER] + 1, sizeof(int));
    model->boolean = calloc((size_t)port_table.counts[BOOLEAN] + 1, sizeof(int));
    model->text = calloc((size_t)port_table.counts[STRING] + 1, TEXT);
    begin_model(model);
    return model;
}

void free_model(Model *model)
{
    free(model->real), free(model->integer), free(model->boolean), free(model->text);
    free(model);
}

void copy_model(const Model *from, Model *to)
{
    Model kept = *to;

    *to = *from;
    to->real = kept.real, to->integer = kept.integer, to->boolean = kept.boolean, to->text = kept.text;
    memcpy(to->real, from->real, (size_t)port_table.counts[REAL] * sizeof(double));
    memcpy(to->integer, from->integer, (size_t)port_table.counts[INTEGER] * sizeof(int));
    memcpy(to->boolean, from->boolean, (size_t)port_table.counts[BOOLEAN] * sizeof(int));
    memcpy(to->text, from->text, (size_t)port_table.counts[STRING] * TEXT);
}

void begin_model(Model *model)
{
    int place, k;
    const Port *port;

    model->state = NEW;
    model->set_up = model->ends = 0;
    model->present = model->stop = model->length = 0.0;
    for (port = ports; port < ports + port_table.ports; port++)
        for (k = 0; k < port->size; k++) {
            const double start = port->starts != NULL ? port->starts[k] : port->start;
            place = port->first + k;
            if (port->kind == REAL)
                model->real[place] = start;
            else if (port->kind == INTEGER)
                model->integer[place] = (int)start;
            else if (port->kind == BOOLEAN)
                model->boolean[place] = start != 0.0;
            else
                strcpy(model->text[place], port->text);
        }
}

/* Return whether all references are of the kind, and nothing is NULL. */
static int is_list(Kind kind, const fmi2ValueReference vr[], size_t n, const void *values)
{
    const fmi2ValueReference first = first_of(kind);
    size_t k;

    if (n > 0 && (vr == NULL || values == NULL))
        return 0;
    for (k = 0; k < n; k++)
        if (vr[k] < first || vr[k] - first >= (fmi2ValueReference)port_table.counts[kind])
            return 0;
    return 1;
}

Answer may_read(const Model *model, Kind kind, const fmi2ValueReference vr[], size_t n, const void *values)
{
    int outputs = 0, computed = 0;
    size_t k;

    if (!is_list(kind, vr, n, values) || model->state == NEW)
        return ERROR_ONLY;
    for (k = 0; k < n; k++) {
        outputs |= port_of(vr[k])->flags & OUTPUT;
        computed |= port_of(vr[k])->flags & (ON_DEMAND | FOLLOWS_INPUTS);
    }
    return (outputs && model->state == INITIALISING) || (computed && model->state != BROKEN) ? EITHER : OK_ONLY;
}

static int is_text(const char *text)
{
    size_t length, k;

    if (text == NULL)
        return 0;
    length = strlen(text);
    for (k = 0; k < length; k++) /* the texts of the fuzzer are ASCII, or not UTF-8 */
        if ((unsigned char)text[k] >= 0x80)
            return 0;
    return length < TEXT;
}

/* Return whether the value of a reference is within its port's limits. */
static int is_value(Kind kind, const Port *port, const void *values, size_t k)
{
    if (kind == STRING)
        return is_text(((const char *const *)values)[k]);
    if (kind == REAL || kind == INTEGER) {
        const double value = kind == REAL ? ((const double *)values)[k] : ((const int *)values)[k];
        return value >= port->least && value <= port->greatest;
    }
    return 1;
}

Answer may_write(const Model *model, Kind kind, const fmi2ValueReference vr[], size_t n, const void *values)
{
    int tuned = 0;
    size_t k;

    if (!is_list(kind, vr, n, values) || model->state == ENDED || model->state == BROKEN)
        return ERROR_ONLY;
    for (k = 0; k < n; k++) {
        const Port *port = port_of(vr[k]);
        if (port->flags & OUTPUT || !is_value(kind, port, values, k))
            return ERROR_ONLY;
        if (model->state == RUNNING && port->flags & PARAMETER && !(port->flags & TUNABLE))
            return ERROR_ONLY;
        tuned |= port->flags & TUNABLE;
    }
    return tuned && model->state == RUNNING ? EITHER : OK_ONLY;
}

void write_values(Model *model, Kind kind, const fmi2ValueReference vr[], size_t n, const void *values)
{
    const fmi2ValueReference first = first_of(kind);
    size_t k;

    for (k = 0; k < n; k++) {
        const size_t place = vr[k] - first;
        if (kind == REAL)
            model->real[place] = ((const double *)values)[k];
        else if (kind == INTEGER)
            model->integer[place] = ((const int *)values)[k];
        else if (kind == BOOLEAN)
            model->boolean[place] = ((const int *)values)[k] != 0;
        else
            strcpy(model->text[place], ((const char *const *)values)[k]);
    }
}

/* What errs by rounding is accepted, what errs by a thousandth of a step is not; between both the FMU decides. */
Answer may_step(const Model *model, double time, double step)
{
    const double due = model->length > 0.0 ? model->length : step;

    if (model->state != RUNNING || !(step > 0.0 && step <= DBL_MAX) || !(fabs(time) <= DBL_MAX))
        return ERROR_ONLY;
    if (fabs(step - due) > 1e-3 * due || fabs(time - model->present) > 1e-3 * step + 1e-9 * fabs(model->present))
        return ERROR_ONLY;
    if (model->ends && time + step - model->stop > 1e-3 * step + 1e-9 * fabs(model->present))
        return ERROR_ONLY;
    return EITHER;
}

Answer may_differentiate(const Model *model, const fmi2ValueReference unknown[], size_t unknowns,
                         const fmi2ValueReference known[], size_t knowns, const double seed[], const void *found)
{
    size_t k;

    if (port_table.differentiate == NULL || model->state == NEW || model->state == BROKEN)
        return ERROR_ONLY;
    if (!is_list(REAL, unknown, unknowns, found) || !is_list(REAL, known, knowns, seed))
        return ERROR_ONLY;
    for (k = 0; k < unknowns; k++)
        if (!(port_of(unknown[k])->flags & OUTPUT))
            return ERROR_ONLY;
    for (k = 0; k < knowns; k++)
        if (!(port_of(known[k])->flags & INPUT) || !(fabs(seed[k]) <= DBL_MAX))
            return ERROR_ONLY;
    return EITHER;
}

/* Read all elements of a port into one of the arrays. */
static fmi2Status read_port(fmi2Component c, const Port *port, double *reals, int *numbers, fmi2String *texts)
{
    static fmi2ValueReference *references;
    const size_t n = (size_t)port->size;
    size_t k;

    if (references == NULL)
        references = calloc((size_t)port_table.variables + 1, sizeof *references);
    for (k = 0; k < n; k++)
        references[k] = first_of(port->kind) + (fmi2ValueReference)port->first + (fmi2ValueReference)k;
    switch (port->kind) {
    case REAL: return fmi2GetReal(c, references, n, reals);
    case INTEGER: return fmi2GetInteger(c, references, n, numbers);
    case BOOLEAN: return fmi2GetBoolean(c, references, n, numbers);
    default: return fmi2GetString(c, references, n, texts);
    }
}

void compare(fmi2Component c, const Model *model)
{
    static double *reals;
    static int *numbers;
    static fmi2String *texts;
    const unsigned long before = lines;
    const Port *port;
    int k;

    if (reals == NULL) {
        reals = calloc((size_t)port_table.variables + 1, sizeof *reals);
        numbers = calloc((size_t)port_table.variables + 1, sizeof *numbers);
        texts = calloc((size_t)port_table.variables + 1, sizeof *texts);
    }
    if (model->state == NEW) /* nothing can be read */
        return;
    for (port = ports; port < ports + port_table.ports; port++) {
        if (port->flags & OUTPUT && !(port->kind == REAL && model->state == BROKEN))
            continue;
        if (read_port(c, port, reals, numbers, texts) != fmi2OK)
            fail("%s cannot be read", port->name);
        for (k = 0; k < port->size; k++) {
            const int place = port->first + k;
            int same;
            if (port->kind == REAL)
                same = port->flags & OUTPUT ? isnan(reals[k]) : reals[k] == model->real[place];
            else if (port->kind == STRING)
                same = strcmp(texts[k], model->text[place]) == 0;
            else
                same = numbers[k] == (port->kind == INTEGER ? model->integer : model->boolean)[place];
            if (!same)
                fail("%s, element %d, has another value than it was given", port->name, k + 1);
        }
    }
    if (lines != before)
        fail("reading logged a line");
}
