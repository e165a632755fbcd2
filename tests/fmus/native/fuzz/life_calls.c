/* Calls of the life cycle, steps and inquiries, with right and wrong arguments. */
#include "slots.h"

#include <math.h>
#include <string.h>

#ifndef STEP
#define STEP 0.01 /* s, of the default experiment */
#endif

static int is_finite(double value) { return value - value == 0.0; }

void setup(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    Model *model = slot->model;
    const int plain = choose(input, 4) != 0, tolerant = plain ? 0 : (int)choose(input, 2);
    const int ends = choose(input, 4) == 3;
    const double start = plain ? 0.0 : odd_number(input), tolerance = odd_number(input);
    const double stop = plain ? STEP * choose(input, 64) : odd_number(input);
    const int right = is_finite(start) && (!ends || (is_finite(stop) && stop >= start)) &&
                      (!tolerant || (is_finite(tolerance) && tolerance >= 0.0));
    const fmi2Status status = fmi2SetupExperiment(slot->c, tolerant, tolerance, start, ends, stop);

    judge(slot, "setup", status, model->state == NEW && right ? OK_ONLY : ERROR_ONLY, before);
    if (status != fmi2OK)
        return;
    model->set_up = 1;
    model->ends = ends;
    model->stop = stop;
    model->present = start;
}

void enter(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    const Answer expected = slot->model->state == NEW && slot->model->set_up ? OK_ONLY : ERROR_ONLY;
    const fmi2Status status = fmi2EnterInitializationMode(slot->c);

    (void)input;
    judge(slot, "enter", status, expected, before);
    if (status == fmi2OK)
        slot->model->state = INITIALISING;
}

void leave(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    const Answer expected = slot->model->state == INITIALISING ? EITHER : ERROR_ONLY;
    const fmi2Status status = fmi2ExitInitializationMode(slot->c);

    (void)input;
    judge(slot, "leave", status, expected, before);
    if (status == fmi2OK) {
        slot->model->state = RUNNING;
        slot->model->length = 0.0;
    }
}

static void step(Slot *slot, double time, double length)
{
    const unsigned long before = lines;
    Model *model = slot->model;
    const fmi2Status status = fmi2DoStep(slot->c, time, length, 1);

    judge(slot, "step", status, may_step(model, time, length), before);
    if (status != fmi2OK)
        return;
    count_step();
    model->present = time + length;
    if ((this_fmu.equal_steps || this_fmu.step_set_by != NULL) && model->length == 0.0)
        model->length = length;
}

void do_right_step(Slot *slot, Input *input)
{
    unsigned count = 1 + choose(input, 8);

    while (count-- > 0 && (slot->c == NULL || slot->model->state != BROKEN))
        step(slot, slot->model->present, slot->model->length > 0.0 ? slot->model->length : STEP);
}

void do_step(Slot *slot, Input *input)
{
    const double present = slot->model->present;
    double time = present, length = STEP;

    switch (choose(input, 6)) {
    case 0: time = odd_number(input); break;
    case 1: time = present + STEP; break;
    case 2: time = present - STEP; break;
    default: break;
    }
    switch (choose(input, 6)) {
    case 0: length = odd_number(input); break;
    case 1: length = STEP * choose(input, 16); break;
    case 2: length = -STEP; break;
    default: break;
    }
    step(slot, time, length);
}

void end(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    const Answer expected = slot->model->state == RUNNING ? OK_ONLY : ERROR_ONLY;
    const fmi2Status status = fmi2Terminate(slot->c);

    (void)input;
    judge(slot, "terminate", status, expected, before);
    if (status == fmi2OK)
        slot->model->state = ENDED;
}

void reset(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    const fmi2Status status = fmi2Reset(slot->c);

    (void)input;
    judge(slot, "reset", status, OK_ONLY, before);
    if (status == fmi2OK)
        begin_model(slot->model);
}

/* Free the instance, or make one. */
void instance_again(Slot *slot, Input *input)
{
    static const char *const names[] = {"one", "zwei", NULL, "", " \t"};
    static const char *const guids[] = {"", NULL, "{00000000-0000\n0000-0000-000000000000}"};
    const unsigned name = choose(input, 16), guid = choose(input, 16), kind = choose(input, 16);
    const unsigned long before = lines;
    const int right = (name < 2 || name > 4) && (guid == 0 || guid > 2) && kind != 1;

    if (slot->c != NULL) {
        empty_slot(slot);
        return;
    }
    slot->c = fmi2Instantiate(name > 4 ? "three" : names[name], kind == 1 ? fmi2ModelExchange : fmi2CoSimulation,
                              guid == 0 || guid > 2 ? this_fmu.guid : guids[guid], NULL, &host_functions,
                              (int)choose(input, 2), (int)choose(input, 2));
    if (right ? slot->c == NULL && memory_left < 0 : slot->c != NULL)
        fail("instantiating with name %u, GUID %u and type %u", name, guid, kind);
    if (lines - before != (slot->c == NULL))
        fail("instantiating logged %lu lines", lines - before);
    begin_model(slot->model);
}

void log_choice(Slot *slot, Input *input)
{
    static const char *const names[] = {"logStatusError", "logStatusError", "log\nEvents", "", NULL};
    const unsigned long before = lines;
    const size_t n = choose(input, 4);
    const char *some[4];
    const int null = choose(input, 16) == 15 && n > 0;
    unsigned long unknown = 0, nulls = 0;
    fmi2Status status;
    size_t k;

    for (k = 0; k < n; k++) {
        some[k] = names[choose(input, 5)];
        nulls += some[k] == NULL;
        unknown += some[k] != NULL && strcmp(some[k], "logStatusError") != 0;
    }
    status = fmi2SetDebugLogging(slot->c, (int)choose(input, 2), n, null ? NULL : some);
    if (slot->c == NULL || null || nulls > 0 || unknown == 0) {
        judge(slot, "set logging", status, null || nulls > 0 ? ERROR_ONLY : OK_ONLY, before);
        return;
    }
    count_call(status);
    if (status != fmi2Warning || lines - before != unknown)
        fail("%lu unknown categories: status %d, %lu lines", unknown, (int)status, lines - before);
}

void inquire(Slot *slot, Input *input)
{
    const unsigned long before = lines;
    const unsigned which = choose(input, 5), kind = choose(input, 5);
    const int null = choose(input, 16) == 15;
    const int allowed = !null && (slot->model->state == RUNNING || slot->model->state == ENDED);
    const int answered = (which == 1 && kind == fmi2LastSuccessfulTime) || (which == 3 && kind == fmi2Terminated);
    fmi2Status status, asked = fmi2OK;
    double real = 0.0;
    int whole = 0;
    fmi2String text = NULL;

    switch (which) {
    case 0: status = fmi2GetStatus(slot->c, (fmi2StatusKind)kind, null ? NULL : &asked); break;
    case 1: status = fmi2GetRealStatus(slot->c, (fmi2StatusKind)kind, null ? NULL : &real); break;
    case 2: status = fmi2GetIntegerStatus(slot->c, (fmi2StatusKind)kind, null ? NULL : &whole); break;
    case 3: status = fmi2GetBooleanStatus(slot->c, (fmi2StatusKind)kind, null ? NULL : &whole); break;
    default: status = fmi2GetStringStatus(slot->c, (fmi2StatusKind)kind, null ? NULL : &text);
    }
    if (slot->c == NULL || !allowed || answered) {
        judge(slot, "inquiry", status, allowed ? OK_ONLY : ERROR_ONLY, before);
        if (slot->c != NULL && allowed && which == 1 && real != slot->model->present)
            fail("the last successful time is %.17g, not %.17g", real, slot->model->present);
        return;
    }
    count_call(status);
    if (status != fmi2Discard || lines - before != 1)
        fail("inquiry %u of kind %u: status %d, %lu lines", which, kind, (int)status, lines - before);
}

void never(Slot *slot, Input *input)
{
    const unsigned long before = lines;

    (void)input;
    judge(slot, "cancel a step", fmi2CancelStep(slot->c), ERROR_ONLY, before);
}
