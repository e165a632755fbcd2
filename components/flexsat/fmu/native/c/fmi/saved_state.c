/* The state of an instance as bytes: exact, and to be read by another process.

Layout: Head, reals, integers, booleans, texts of STRING_SIZE bytes, the state of the model; then, in what is serialised, 8
bytes that damaged ones do not fit. All numbers are those of a little-endian machine. */
#include "identity.h"
#include "instance.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef struct Head { /* no padding: 40 + 4 doubles + 6 integers of 32 bits */
    char guid[40];
    double present, start_time, length; /* s */
    uint64_t state_size;
    int32_t layout, phase, set_up, started, stale, inputs_set;
} Head;

enum { LAYOUT = 1 };

/* Bytes of all values of a kind. */
static size_t size_of(Kind kind)
{
    static const size_t sizes[KINDS] = {sizeof(double), sizeof(int), sizeof(int), STRING_SIZE};

    return (size_t)port_table.counts[kind] * sizes[kind];
}

size_t values_size(void) { return size_of(REAL) + size_of(INTEGER) + size_of(BOOLEAN) + size_of(STRING); }

size_t saved_size(const Instance *instance)
{
    return sizeof(Head) + values_size() + (instance->started ? instance->component.state_size : 0);
}

static unsigned char *append(unsigned char *end, const void *bytes, size_t size)
{
    if (size > 0)
        memcpy(end, bytes, size);
    return end + size;
}

static unsigned char *append_values(const Component *component, unsigned char *bytes)
{
    int k;

    bytes = append(bytes, component->real, size_of(REAL));
    bytes = append(bytes, component->integer, size_of(INTEGER));
    bytes = append(bytes, component->boolean, size_of(BOOLEAN));
    for (k = 0; k < port_table.counts[STRING]; k++, bytes += STRING_SIZE) {
        memset(bytes, 0, STRING_SIZE);
        memcpy(bytes, component->string[k], strlen(component->string[k]));
    }
    return bytes;
}

void save(const Instance *instance, unsigned char *bytes)
{
    const Component *component = &instance->component;
    Head head;

    memset(&head, 0, sizeof head);
    strncpy(head.guid, this_fmu.guid, sizeof head.guid - 1);
    head.present = instance->present;
    head.start_time = component->start_time;
    head.length = instance->length;
    head.state_size = instance->started ? component->state_size : 0;
    head.layout = LAYOUT;
    head.phase = (int32_t)instance->phase;
    head.set_up = instance->set_up;
    head.started = instance->started;
    head.stale = instance->stale;
    head.inputs_set = instance->inputs_set;
    bytes = append(bytes, &head, sizeof head);
    bytes = append_values(component, bytes);
    append(bytes, component->state, (size_t)head.state_size);
}

/* FNV-1a, 64 bits: every change of a single byte changes it. */
void digest_of(const unsigned char *bytes, size_t size, unsigned char digest[DIGEST_SIZE])
{
    uint64_t sum = 0xcbf29ce484222325u;
    size_t k;

    for (k = 0; k < size; k++)
        sum = (sum ^ bytes[k]) * 0x100000001b3u;
    for (k = 0; k < DIGEST_SIZE; k++)
        digest[k] = (unsigned char)(sum >> (8 * k));
}

static int is_flag(int32_t value) { return value == 0 || value == 1; }

static int is_life_cycle(const Head *head)
{
    const int running = head->phase == STEPPING || head->phase == TERMINATED;

    return head->phase >= INSTANTIATED && head->phase <= FAILED && is_flag(head->set_up) && is_flag(head->started)
           && is_flag(head->stale) && is_flag(head->inputs_set) && isfinite(head->present)
           && isfinite(head->start_time) && head->length >= 0.0 && isfinite(head->length)
           && !(running && !(head->started && head->set_up)) && !(head->state_size > 0 && !head->started);
}

/* Refuse values that a host could not have set, and outputs that are no results; those of a failed instance are
not-a-number. */
static int are_values(const unsigned char *bytes, int failed, char *reason)
{
    const unsigned char *integers = bytes + size_of(REAL);
    const unsigned char *booleans = integers + size_of(INTEGER);
    const unsigned char *texts = booleans + size_of(BOOLEAN);
    char name[REASON_SIZE], why[REASON_SIZE], number[NUMBER_SIZE];
    const Port *port;
    const char *text;
    double real;
    int integer, place;

    for (port = ports; port < ports + port_table.ports; port++)
        for (place = port->first; place < port->first + port->size; place++) {
            switch (port->kind) {
            case REAL: memcpy(&real, bytes + (size_t)place * sizeof real, sizeof real); break;
            case INTEGER:
                memcpy(&integer, integers + (size_t)place * sizeof integer, sizeof integer);
                real = integer;
                break;
            case BOOLEAN:
                memcpy(&integer, booleans + (size_t)place * sizeof integer, sizeof integer);
                if (!is_flag(integer)) {
                    snprintf(reason, REASON_SIZE, "%s must be boolean, got %d in the saved state", port->name, integer);
                    return 0;
                }
                continue;
            default:
                text = (const char *)texts + (size_t)place * STRING_SIZE;
                if (text[STRING_SIZE - 1] != '\0' || !is_utf8(text)) {
                    snprintf(reason, REASON_SIZE, "%s is no text in the saved state", port->name);
                    return 0;
                }
                continue;
            }
            if (port->flags & OUTPUT) {
                if (failed || fabs(real) <= DBL_MAX)
                    continue;
                snprintf(why, sizeof why, "must be finite, got %s", number_text(real, number));
            } else if (acceptable(port, real, why))
                continue;
            snprintf(reason, REASON_SIZE, "%.200s %.500s in the saved state", variable_name(port, place, name), why);
            return 0;
        }
    return 1;
}

int is_saved_state(const unsigned char *bytes, size_t size, char reason[REASON_SIZE])
{
    Head head;

    if (size < sizeof head + values_size()) {
        strcpy(reason, "these bytes are not a saved state of this component: too few");
        return 0;
    }
    memcpy(&head, bytes, sizeof head);
    head.guid[sizeof head.guid - 1] = '\0';
    if (strcmp(head.guid, this_fmu.guid) != 0) {
        snprintf(reason, REASON_SIZE, "the saved state belongs to %s, this is %s", head.guid, this_fmu.guid);
        return 0;
    }
    if (head.layout != LAYOUT) {
        snprintf(reason, REASON_SIZE, "the saved state has layout %d; this component reads layout %d", (int)head.layout,
                 LAYOUT);
        return 0;
    }
    if (head.state_size != size - sizeof head - values_size()) {
        strcpy(reason, "these bytes are not a saved state of this component: of another length");
        return 0;
    }
    if (!is_life_cycle(&head)) {
        strcpy(reason, "the saved state has a life cycle that no instance can have");
        return 0;
    }
    return are_values(bytes + sizeof head, head.phase == FAILED, reason);
}

static void restore_values(Component *component, const unsigned char *bytes)
{
    int k;

    memcpy(component->real, bytes, size_of(REAL));
    bytes += size_of(REAL);
    if (size_of(INTEGER) > 0)
        memcpy(component->integer, bytes, size_of(INTEGER));
    bytes += size_of(INTEGER);
    if (size_of(BOOLEAN) > 0)
        memcpy(component->boolean, bytes, size_of(BOOLEAN));
    bytes += size_of(BOOLEAN);
    for (k = 0; k < port_table.counts[STRING]; k++, bytes += STRING_SIZE)
        memcpy(component->string[k], bytes, STRING_SIZE);
}

/* Return whether the parameters of a saved state are those that the model has started with. */
static int same_parameters(const Component *component, const unsigned char *bytes)
{
    const unsigned char *integers = bytes + size_of(REAL);
    const unsigned char *booleans = integers + size_of(INTEGER);
    const unsigned char *texts = booleans + size_of(BOOLEAN);
    const Port *port;
    int k, differ = 0;

    for (port = ports; port < ports + port_table.ports && !differ; port++) {
        const size_t first = (size_t)port->first, size = (size_t)port->size;
        if (!(port->flags & PARAMETER))
            continue;
        switch (port->kind) {
        case REAL: differ = memcmp(component->real + first, bytes + first * 8, size * 8) != 0; break;
        case INTEGER: differ = memcmp(component->integer + first, integers + first * 4, size * 4) != 0; break;
        case BOOLEAN: differ = memcmp(component->boolean + first, booleans + first * 4, size * 4) != 0; break;
        default:
            for (k = port->first; k < port->first + port->size; k++)
                differ |= strcmp(component->string[k], (const char *)texts + (size_t)k * STRING_SIZE) != 0;
        }
    }
    return !differ;
}

static void clear_inputs(Component *component)
{
    const Port *port;
    int k;

    for (port = ports; port < ports + port_table.ports; port++)
        for (k = port->first; k < port->first + port->size && port->flags & INPUT; k++) {
            if (port->kind == REAL)
                component->real[k] = 0.0;
            else if (port->kind == BOOLEAN)
                component->boolean[k] = 0;
        }
}

/* Start the model with the parameters of a saved state, if it has not started with them already. */
static int restart(Instance *instance, const Head *head, const unsigned char *values, char *reason)
{
    Component *component = &instance->component;
    const int same = instance->started && component->start_time == head->start_time
                     && same_parameters(component, values);

    instance->started = 0; /* until all of it is restored */
    restore_values(component, values);
    component->start_time = head->start_time;
    if (same || !head->started)
        return 1;
    clear_inputs(component); /* those that a run has come to may be none to start with */
    if (!start_component(instance)) {
        snprintf(reason, REASON_SIZE, "%s", component->message);
        return 0;
    }
    restore_values(component, values);
    return 1;
}

/* Restore the model, which has started with the parameters of the saved state. */
static int restore_model(Instance *instance, const Head *head, const unsigned char *values, char *reason)
{
    Component *component = &instance->component;
    const int sampled = this_fmu.equal_steps && instance->fixed_step == 0.0;

    if (head->state_size != component->state_size) {
        strcpy(reason, "the saved state does not fit its own parameters");
        return 0;
    }
    if (sampled && head->length > 0.0 && head->length != instance->length) {
        if (component_first_step(component, head->length)) {
            snprintf(reason, REASON_SIZE, "%s", component->message);
            return 0;
        }
        restore_values(component, values);
    }
    append(component->state, values + values_size(), component->state_size);
    component->step_length = sampled ? head->length : instance->fixed_step;
    if (component_restored(component)) {
        snprintf(reason, REASON_SIZE, "%s", component->message);
        return 0;
    }
    return 1;
}

int restore(Instance *instance, const unsigned char *bytes, size_t size, char reason[REASON_SIZE], int *model)
{
    const unsigned char *values = bytes + sizeof(Head);
    const double start_time = instance->component.start_time;
    Head head;

    *model = 0;
    if (!is_saved_state(bytes, size, reason))
        return 0;
    memcpy(&head, bytes, sizeof head);
    *model = 1;
    append_values(&instance->component, instance->values_before);
    if (!restart(instance, &head, values, reason) ||
        (head.started && !restore_model(instance, &head, values, reason))) {
        restore_values(&instance->component, instance->values_before);
        instance->component.start_time = start_time;
        return 0;
    }
    instance->length = head.length;
    instance->present = head.present;
    instance->set_up = head.set_up;
    instance->started = head.started;
    instance->stale = head.stale;
    instance->inputs_set = head.inputs_set;
    instance->phase = (Phase)head.phase;
    strcpy(instance->failure, instance->phase == FAILED ? "the state was saved after an error" : "");
    return 1;
}
