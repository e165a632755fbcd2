#include "program_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "library.h"
#include "memory.h"
#include "operations.h"

static const char magic[] = "LOCKSTEP BUNDLE\1";

typedef struct {
    bundle_t *bundle;
    const unsigned char *at, *end;
    int bad; /* shorter than it says, or no memory */
} reader_t;

static const void *bytes(reader_t *in, size_t size)
{
    static const double zeros[2];
    const void *found = in->at;

    if (in->bad || size > (size_t)(in->end - in->at)) {
        in->bad = 1;
        return zeros;
    }
    in->at += size;
    return found;
}

static uint32_t count(reader_t *in)
{
    uint32_t value;

    memcpy(&value, bytes(in, sizeof value), sizeof value);
    return value;
}

static int64_t whole(reader_t *in)
{
    int64_t value;

    memcpy(&value, bytes(in, sizeof value), sizeof value);
    return value;
}

static double real(reader_t *in)
{
    double value;

    memcpy(&value, bytes(in, sizeof value), sizeof value);
    return value;
}

static const char *text(reader_t *in)
{
    uint32_t length = count(in);
    const char *found = bytes(in, (size_t)length + 1);

    return in->bad ? "" : found;
}

/* Return memory for so many things that follow, each of which takes 4 bytes of the file or more. */
static void *memory(reader_t *in, uint32_t number, size_t size)
{
    void *found = NULL;

    if (!in->bad && number <= (size_t)(in->end - in->at) / 4)
        found = keep(in->bundle, number, size);
    if (found == NULL)
        in->bad = 1;
    return found;
}

static counts_t counts(reader_t *in)
{
    counts_t found = {0, NULL};
    uint32_t number = count(in);

    found.items = memory(in, number, sizeof *found.items);
    if (found.items != NULL) {
        found.count = number;
        memcpy(found.items, bytes(in, number * sizeof *found.items), number * sizeof *found.items);
    }
    return found;
}

/* As counts, for positions of 64 bits. */
static int64_t *positions(reader_t *in, uint32_t expected)
{
    counts_t found = counts(in);
    int64_t *wide = in->bad ? NULL : keep(in->bundle, found.count, sizeof *wide);

    if (wide == NULL || found.count != expected) {
        in->bad = 1;
        return NULL;
    }
    for (uint32_t k = 0; k < found.count; k++)
        wide[k] = (int64_t)found.items[k];
    return wide;
}

static double *reals(reader_t *in, uint32_t expected)
{
    uint32_t number = count(in);
    double *found;

    if (number == 0)
        return NULL;
    found = memory(in, number, sizeof *found);
    if (found == NULL || number != expected) {
        in->bad = 1;
        return NULL;
    }
    memcpy(found, bytes(in, number * sizeof *found), number * sizeof *found);
    return found;
}

static void limit(reader_t *in, uint32_t value, uint32_t below)
{
    if (value >= below)
        in->bad = 1;
}

static void largest(reader_t *in, uint32_t number)
{
    if (number > in->bundle->most_values)
        in->bundle->most_values = number;
}

static set_t *settings(reader_t *in, uint32_t *number, int initial)
{
    set_t *found;

    *number = count(in);
    found = memory(in, *number, sizeof *found);
    for (uint32_t k = 0; !in->bad && k < *number; k++) {
        set_t *set = &found[k];
        counts_t targets;
        if (initial)
            set->producer = count(in);
        limit(in, set->producer, in->bundle->component_count);
        set->type = count(in);
        limit(in, set->type, BUS_TYPES);
        targets = counts(in);
        set->count = targets.count;
        set->targets = targets.items;
        set->sources = positions(in, set->count);
        set->gains = reals(in, set->count);
        set->biases = reals(in, set->count);
        if (in->bad || (set->gains == NULL) != (set->biases == NULL)
            || (set->gains != NULL && set->type != REAL)) {
            in->bad = 1;
            break;
        }
        for (uint32_t n = 0; n < set->count; n++)
            limit(in, (uint32_t)set->sources[n], initial ? in->bundle->slot_count[set->type] : in->bundle->bus_size[set->type]);
        set->buffer = keep(in->bundle, set->count, sizes[set->type]);
        if (set->buffer == NULL)
            in->bad = 1;
        largest(in, set->count);
    }
    return found;
}

static get_t *fetches(reader_t *in, uint32_t *number, int initial)
{
    get_t *found;

    *number = count(in);
    found = memory(in, *number, sizeof *found);
    for (uint32_t k = 0; !in->bad && k < *number; k++) {
        get_t *get = &found[k];
        counts_t references, used;
        uint32_t room;
        get->type = count(in);
        limit(in, get->type, BUS_TYPES);
        references = counts(in);
        get->start = count(in);
        used = counts(in);
        if (in->bad || used.count != references.count) {
            in->bad = 1;
            break;
        }
        get->count = references.count;
        get->references = references.items;
        get->unused = keep(in->bundle, get->count, sizeof *get->unused);
        for (uint32_t n = 0; get->unused != NULL && n < get->count; n++) {
            get->unused[n] = used.items[n] == 0;
            get->checked |= used.items[n] != 0;
        }
        if (get->unused == NULL)
            in->bad = 1;
        room = initial ? in->bundle->slot_count[get->type] : in->bundle->bus_size[get->type];
        if (get->start > room || get->count > room - get->start)
            in->bad = 1;
    }
    return found;
}

static void starts(reader_t *in, component_t *component)
{
    for (int type = 0; !in->bad && type < ALL_TYPES; type++) {
        start_t *start = &component->starts[type];
        start->references = counts(in);
        start->values = in->bad ? NULL : keep(in->bundle, start->references.count, sizes[type]);
        if (start->values == NULL)
            in->bad = 1;
        for (uint32_t k = 0; !in->bad && k < start->references.count; k++) {
            if (type == REAL)
                ((double *)start->values)[k] = real(in);
            else if (type == STRING)
                ((const char **)start->values)[k] = text(in);
            else
                ((int32_t *)start->values)[k] = (int32_t)count(in);
        }
        largest(in, start->references.count);
    }
}

static void components(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->component_count = count(in);
    bundle->components = memory(in, bundle->component_count, sizeof *bundle->components);
    for (uint32_t k = 0; !in->bad && k < bundle->component_count; k++) {
        component_t *component = &bundle->components[k];
        component->bundle = bundle;
        component->name = text(in);
        component->folder = text(in);
        component->identifier = text(in);
        component->guid = text(in);
        component->flags = count(in);
        component->period = count(in);
        component->offset = count(in);
        component->length = real(in);
        component->tolerance = real(in);
        if (component->period == 0)
            in->bad = 1;
        starts(in, component);
    }
}

static void ports(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->port_count = count(in);
    bundle->ports = memory(in, bundle->port_count, sizeof *bundle->ports);
    for (uint32_t k = 0; !in->bad && k < bundle->port_count; k++) {
        port_t *port = &bundle->ports[k];
        port->kind = count(in);
        limit(in, port->kind, TUNABLE + 1);
        port->type = count(in);
        limit(in, port->type, ALL_TYPES);
        if (port->kind == OUTPUT) {
            port->place = count(in);
            if (!in->bad && port->type != STRING)
                limit(in, port->place, bundle->row_size[port->type]);
        } else if (port->type == REAL)
            port->real_start = real(in);
        else if (port->type == STRING)
            port->text_start = text(in);
        else
            port->whole_start = (int32_t)count(in);
        port->target_count = count(in);
        port->targets = memory(in, port->target_count, sizeof *port->targets);
        for (uint32_t n = 0; !in->bad && n < port->target_count; n++) {
            target_t *target = &port->targets[n];
            target->component = count(in);
            limit(in, target->component, bundle->component_count);
            target->reference = count(in);
            target->gain = real(in);
            target->bias = real(in);
        }
        if (port->kind == OUTPUT && port->target_count != 1)
            in->bad = 1;
    }
    largest(in, bundle->port_count);
}

static void operations(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->order = counts(in);
    if (bundle->order.count != bundle->component_count)
        in->bad = 1;
    for (uint32_t k = 0; !in->bad && k < bundle->component_count; k++) {
        component_t *component = &bundle->components[k];
        limit(in, bundle->order.items[k], bundle->component_count);
        component->initial_sets = settings(in, &component->initial_set_count, 1);
        component->initial_gets = fetches(in, &component->initial_get_count, 1);
        component->initial_bus = fetches(in, &component->initial_bus_count, 0);
    }
    bundle->step_count = count(in);
    bundle->steps = memory(in, bundle->step_count, sizeof *bundle->steps);
    for (uint32_t k = 0; !in->bad && k < bundle->step_count; k++) {
        step_t *step = &bundle->steps[k];
        step->component = count(in);
        limit(in, step->component, bundle->component_count);
        step->sets = settings(in, &step->set_count, 0);
        step->gets = fetches(in, &step->get_count, 0);
    }
}

static void ticks(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->row_count = count(in);
    bundle->rows = memory(in, bundle->row_count, sizeof *bundle->rows);
    for (uint32_t k = 0; !in->bad && k < bundle->row_count; k++)
        for (int type = 0; !in->bad && type < BUS_TYPES; type++) {
            bundle->rows[k][type] = counts(in);
            if (bundle->rows[k][type].count != bundle->row_size[type])
                in->bad = 1;
            for (uint32_t n = 0; !in->bad && n < bundle->row_size[type]; n++)
                limit(in, bundle->rows[k][type].items[n], bundle->bus_size[type]);
        }
    bundle->cycle = count(in);
    bundle->ticks = memory(in, bundle->cycle, sizeof *bundle->ticks);
    for (uint32_t k = 0; !in->bad && k < bundle->cycle; k++) {
        tick_t *tick = &bundle->ticks[k];
        tick->early = counts(in);
        tick->late = counts(in);
        tick->row = count(in);
        limit(in, tick->row, bundle->row_count + 1);
        for (uint32_t n = 0; !in->bad && n < tick->early.count; n++)
            limit(in, tick->early.items[n], bundle->step_count);
        for (uint32_t n = 0; !in->bad && n < tick->late.count; n++)
            limit(in, tick->late.items[n], bundle->step_count);
    }
    if (bundle->cycle == 0 || in->at != in->end)
        in->bad = 1;
}

static void buffers(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    for (int type = 0; type < BUS_TYPES; type++) {
        bundle->bus[type] = keep(bundle, bundle->bus_size[type], sizes[type]);
        bundle->slots[type] = keep(bundle, bundle->slot_count[type], sizes[type]);
        bundle->row[type] = keep(bundle, bundle->row_size[type], sizes[type]);
        if (bundle->bus[type] == NULL || bundle->slots[type] == NULL || bundle->row[type] == NULL)
            in->bad = 1;
    }
    bundle->references = keep(bundle, bundle->most_values, sizeof *bundle->references);
    bundle->values = keep(bundle, bundle->most_values, sizeof(double) + sizeof(char *));
    if (bundle->references == NULL || bundle->values == NULL)
        in->bad = 1;
}

static unsigned char *whole_file(const char *path, size_t *size)
{
    FILE *file = open_to_read(path);
    unsigned char *content = NULL;
    long length = -1;

    if (file == NULL)
        return NULL;
    if (fseek(file, 0, SEEK_END) == 0)
        length = ftell(file);
    if (length > 0 && fseek(file, 0, SEEK_SET) == 0)
        content = malloc((size_t)length);
    if (content != NULL && fread(content, 1, (size_t)length, file) != (size_t)length) {
        free(content);
        content = NULL;
    }
    fclose(file);
    *size = content == NULL ? 0 : (size_t)length;
    return content;
}

static void sized(reader_t *in, uint32_t *found)
{
    for (int type = 0; type < BUS_TYPES; type++)
        found[type] = count(in);
}

const char *read_program(bundle_t *bundle)
{
    size_t size = 0, room = strlen(bundle->resources) + sizeof "/program.bin";
    char *path = malloc(room);
    reader_t in = {bundle, NULL, NULL, 0};

    if (path == NULL)
        return "there is no memory";
    snprintf(path, room, "%s/program.bin", bundle->resources);
    bundle->program = whole_file(path, &size);
    free(path);
    if (bundle->program == NULL)
        return "resources/program.bin cannot be read: is fmuResourceLocation the folder of the resources?";
    in.at = bundle->program;
    in.end = bundle->program + size;
    if (size < sizeof magic - 1 || memcmp(bytes(&in, sizeof magic - 1), magic, sizeof magic - 1) != 0)
        return "resources/program.bin is not what the library needs";
    bundle->guid = text(&in);
    bundle->state.length = whole(&in);
    bundle->second = whole(&in);
    bundle->state.second = (double)bundle->second;
    bundle->step_ticks = count(&in);
    sized(&in, bundle->bus_size);
    sized(&in, bundle->slot_count);
    sized(&in, bundle->row_size);
    if (bundle->state.length <= 0 || bundle->second <= 0 || bundle->step_ticks == 0)
        in.bad = 1;
    components(&in);
    ports(&in);
    operations(&in);
    ticks(&in);
    buffers(&in);
    if (!in.bad && !make_operations(bundle))
        in.bad = 1;
    return in.bad ? "resources/program.bin is damaged, or there is no memory" : NULL;
}
