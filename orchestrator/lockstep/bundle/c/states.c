#include "states.h"

#include <stdlib.h>
#include <string.h>

#include "arrays.h"
#include "components.h"
#include "memory.h"
#include "messages.h"
#include "operations.h"
#include "stream.h"

static const char magic[8] = "LSSTATE";

/* A state: `content` are all values of the bundle itself, in the order of `transfer`. */
struct saved {
    saved_t *next;
    size_t size;
    unsigned char *content;
    fmi2FMUstate *components; /* one each; NULL: none */
};

/* The arrays of FMI 3.0 are set whole: what they hold is needed where one element is set. */
static void transfer_arrays(component_t *component, stream_t *stream)
{
    for (int type = 0; type < BUS_TYPES; type++)
        pass(stream, component->arrays[type].memory, component->arrays[type].settable * array_sizes[type]);
    for (uint32_t k = 0; k < component->arrays[STRING].settable; k++)
        pass_text(stream, &((char **)component->arrays[STRING].memory)[k]);
}

/* Measure, write or read all values of a bundle. */
static void transfer(bundle_t *bundle, stream_t *stream)
{
    int32_t life = (int32_t)bundle->life;

    pass(stream, &life, sizeof life);
    bundle->life = (life_t)life;
    pass(stream, &bundle->start, sizeof bundle->start);
    pass(stream, &bundle->stop, sizeof bundle->stop);
    pass(stream, &bundle->tolerance, sizeof bundle->tolerance);
    pass(stream, &bundle->stop_defined, sizeof bundle->stop_defined);
    pass(stream, &bundle->tolerance_defined, sizeof bundle->tolerance_defined);
    pass(stream, &bundle->state.origin, sizeof bundle->state.origin);
    pass(stream, &bundle->state.tick, sizeof bundle->state.tick);
    pass(stream, &bundle->ended, sizeof bundle->ended);
    for (int type = 0; type < BUS_TYPES; type++) {
        pass(stream, bundle->bus[type], bundle->bus_size[type] * sizes[type]);
        pass(stream, bundle->row[type], bundle->row_size[type] * sizes[type]);
    }
    for (uint32_t k = 0; k < bundle->component_count; k++)
        transfer_arrays(&bundle->components[k], stream);
    for (uint32_t k = 0; k < bundle->port_count; k++) {
        port_t *port = &bundle->ports[k];
        if (port->kind == OUTPUT)
            continue;
        pass(stream, &port->given, sizeof port->given);
        if (port->type == REAL)
            pass(stream, &port->real, sizeof port->real);
        else if (port->type == STRING)
            pass_text(stream, &port->text);
        else
            pass(stream, &port->whole, sizeof port->whole);
    }
}

static saved_t *found(const bundle_t *bundle, fmi2FMUstate state)
{
    saved_t *one = bundle->states;

    while (one != NULL && one != state)
        one = one->next;
    return one;
}

static void drop(bundle_t *bundle, saved_t *state)
{
    for (uint32_t k = 0; state->components != NULL && k < bundle->component_count; k++) {
        component_t *component = &bundle->components[k];
        if (state->components[k] != NULL && component->instance != NULL && component->worst < fmi2Fatal)
            judge(component, "FreeFMUstate",
                  component->call.free_state(component->instance, &state->components[k]));
    }
    free(state->components);
    free(state->content);
    free(state);
}

static saved_t *new_state(const bundle_t *bundle, size_t size)
{
    saved_t *state = calloc(1, sizeof *state);

    if (state == NULL)
        return NULL;
    state->size = size;
    state->content = calloc(size + 1, 1);
    state->components = calloc(bundle->component_count + 1u, sizeof *state->components);
    if (state->content != NULL && state->components != NULL)
        return state;
    free(state->components);
    free(state->content);
    free(state);
    return NULL;
}

static void write_content(bundle_t *bundle, saved_t *state)
{
    stream_t stream = {WRITE, state->content, state->content + state->size, 0, 0};

    transfer(bundle, &stream);
}

static size_t content_size(bundle_t *bundle)
{
    stream_t stream = {MEASURE, NULL, NULL, 0, 0};

    transfer(bundle, &stream);
    return stream.size;
}

fmi2Status get_state(bundle_t *bundle, const char *call, fmi2FMUstate *state)
{
    size_t size = content_size(bundle);
    saved_t *made = *state == NULL ? NULL : found(bundle, *state);
    fmi2Status status = fmi2OK;

    if (*state != NULL && made == NULL)
        return refuse(bundle, "%s: the state is none of this instance, nor NULL", call);
    if (made == NULL) {
        made = new_state(bundle, size);
        if (made == NULL)
            return refuse(bundle, "%s: there is no memory", call);
        made->next = bundle->states;
        bundle->states = made;
        *state = made;
    } else if (made->size < size) {
        unsigned char *content = realloc(made->content, size + 1);
        if (content == NULL)
            return refuse(bundle, "%s: there is no memory", call);
        made->content = content;
    }
    made->size = size;
    write_content(bundle, made);
    for (uint32_t k = 0; k < bundle->component_count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[k];
        status = worse(status, judge(component, "GetFMUstate",
                                     component->call.get_state(component->instance, &made->components[k])));
    }
    return status;
}

fmi2Status set_state(bundle_t *bundle, const char *call, fmi2FMUstate state)
{
    saved_t *given = found(bundle, state);
    stream_t stream = {READ, NULL, NULL, 0, 0};
    fmi2Status status = fmi2OK;

    if (given == NULL)
        return refuse(bundle, "%s: the state is none of this instance; serialise a state of another one", call);
    for (uint32_t k = 0; k < bundle->component_count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[k];
        status = worse(status, judge(component, "SetFMUstate",
                                     component->call.set_state(component->instance, given->components[k])));
    }
    if (status > fmi2Warning)
        return status;
    stream.at = given->content;
    stream.end = given->content + given->size;
    transfer(bundle, &stream);
    bundle->propagated = 0;
    if (!stream.bad && bundle->life >= INSTANTIATED && bundle->life < FATAL && bundle->state.tick >= 0) {
        go_to_mark(bundle);
        return status;
    }
    bundle->life = FAILED;
    bundle->state.tick = 0;
    return refuse(bundle, "%s: the state is damaged, or there is no memory", call);
}

static void unlink_state(bundle_t *bundle, const saved_t *state)
{
    saved_t **link = &bundle->states;

    while (*link != state)
        link = &(*link)->next;
    *link = state->next;
}

fmi2Status free_state(bundle_t *bundle, const char *call, fmi2FMUstate *state)
{
    saved_t *given;

    if (state == NULL || *state == NULL)
        return fmi2OK;
    given = found(bundle, *state);
    if (given == NULL)
        return refuse(bundle, "%s: the state is none of this instance", call);
    unlink_state(bundle, given);
    drop(bundle, given);
    *state = NULL;
    return fmi2OK;
}

void free_states(bundle_t *bundle)
{
    while (bundle->states != NULL) {
        saved_t *state = bundle->states;
        bundle->states = state->next;
        drop(bundle, state);
    }
}

/* FNV-1a of 64 bits. */
static uint64_t digest(const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    uint64_t sum = UINT64_C(0xcbf29ce484222325);

    for (size_t k = 0; k < size; k++)
        sum = (sum ^ at[k]) * UINT64_C(0x100000001b3);
    return sum;
}

/* The bytes: magic, GUID, size and content of the bundle's own values, size and state of each component, a digest. */
static size_t head_size(const bundle_t *bundle)
{
    return sizeof magic + strlen(bundle->guid);
}

fmi2Status state_size(bundle_t *bundle, const char *call, fmi2FMUstate state, size_t *size)
{
    const saved_t *given = found(bundle, state);
    fmi2Status status = fmi2OK;

    if (given == NULL)
        return refuse(bundle, "%s: the state is none of this instance", call);
    *size = head_size(bundle) + sizeof(uint64_t) + given->size + sizeof(uint64_t);
    for (uint32_t k = 0; k < bundle->component_count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[k];
        size_t inner = 0;
        status = worse(status, judge(component, "SerializedFMUstateSize",
                                     component->call.state_size(component->instance, given->components[k], &inner)));
        *size += sizeof(uint64_t) + inner;
    }
    return status;
}

fmi2Status serialize(bundle_t *bundle, const char *call, fmi2FMUstate state, void *bytes, size_t size)
{
    const saved_t *given = found(bundle, state);
    stream_t out = {WRITE, bytes, (unsigned char *)bytes + size, 0, 0};
    fmi2Status status = fmi2OK;
    uint64_t length;
    size_t needed = 0;

    if (given == NULL)
        return refuse(bundle, "%s: the state is none of this instance", call);
    status = state_size(bundle, call, state, &needed);
    if (status > fmi2Warning)
        return status;
    if (size < needed)
        return refuse(bundle, "%s: %lu bytes are too few; the state has %lu", call, (unsigned long)size,
                      (unsigned long)needed);
    memcpy(out.at, magic, sizeof magic);
    memcpy(out.at + sizeof magic, bundle->guid, strlen(bundle->guid));
    out.at += head_size(bundle);
    length = given->size;
    pass(&out, &length, sizeof length);
    pass(&out, given->content, given->size);
    for (uint32_t k = 0; k < bundle->component_count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[k];
        size_t inner = 0;
        status = worse(status, judge(component, "SerializedFMUstateSize",
                                     component->call.state_size(component->instance, given->components[k], &inner)));
        length = inner;
        pass(&out, &length, sizeof length);
        if (status <= fmi2Warning && inner <= (size_t)(out.end - out.at))
            status = worse(status, judge(component, "SerializeFMUstate",
                                         component->call.serialize(component->instance, given->components[k],
                                                                   (fmi2Byte *)out.at, inner)));
        out.at += inner;
    }
    length = digest(bytes, (size_t)(out.at - (unsigned char *)bytes));
    pass(&out, &length, sizeof length);
    return status;
}

static fmi2Status read_components(bundle_t *bundle, const char *call, stream_t *in, saved_t *made)
{
    fmi2Status status = fmi2OK;
    uint64_t length = 0;

    for (uint32_t k = 0; k < bundle->component_count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[k];
        pass(in, &length, sizeof length);
        if (in->bad || length > (uint64_t)(in->end - in->at))
            return refuse(bundle, "%s: the bytes are cut off", call);
        status = worse(status, judge(component, "DeSerializeFMUstate",
                                     component->call.deserialize(component->instance, (const fmi2Byte *)in->at,
                                                                 (size_t)length, &made->components[k])));
        in->at += length;
    }
    return status;
}

fmi2Status deserialize(bundle_t *bundle, const char *call, const void *bytes, size_t size, fmi2FMUstate *state)
{
    stream_t in = {READ, NULL, NULL, 0, 0};
    saved_t *made;
    fmi2Status status;
    uint64_t length = 0;
    uint64_t sum = 0;
    unsigned char *copy = malloc(size + 1);

    if (copy == NULL)
        return refuse(bundle, "%s: there is no memory", call);
    memcpy(copy, bytes, size);
    if (size >= sizeof sum)
        memcpy(&sum, copy + size - sizeof sum, sizeof sum);
    if (size < head_size(bundle) + sizeof sum || sum != digest(copy, size - sizeof sum) || memcmp(copy, magic, sizeof magic) != 0
        || memcmp(copy + sizeof magic, bundle->guid, strlen(bundle->guid)) != 0) {
        free(copy);
        return refuse(bundle, "%s: the bytes are no state of this FMU, or damaged", call);
    }
    in.at = copy + head_size(bundle);
    in.end = copy + size - sizeof sum;
    pass(&in, &length, sizeof length);
    made = in.bad || length > (uint64_t)(in.end - in.at) ? NULL : new_state(bundle, (size_t)length);
    if (made == NULL) {
        free(copy);
        return refuse(bundle, "%s: the bytes are cut off, or there is no memory", call);
    }
    pass(&in, made->content, made->size);
    status = read_components(bundle, call, &in, made);
    free(copy);
    if (status > fmi2Warning) {
        drop(bundle, made);
        return status;
    }
    made->next = bundle->states;
    bundle->states = made;
    *state = made;
    return status;
}
