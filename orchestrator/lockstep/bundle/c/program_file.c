#include "program_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "library.h"
#include "memory.h"
#include "operations.h"
#include "program_arrays.h"
#include "reader.h"

static const char magic[] = "LOCKSTEP BUNDLE\2";

static void names(reader_t *in, component_t *component)
{
    for (int type = 0; !in->bad && type < BUS_TYPES; type++) {
        names_t *found = &component->names[type];
        found->references = read_counts(in);
        found->texts = read_memory(in, found->references.count, sizeof *found->texts);
        for (uint32_t k = 0; !in->bad && k < found->references.count; k++)
            found->texts[k] = read_text(in);
    }
}

static void starts(reader_t *in, component_t *component)
{
    for (int type = 0; !in->bad && type < ALL_TYPES; type++) {
        start_t *start = &component->starts[type];
        start->references = read_counts(in);
        start->values = read_values(in, type, start->references.count);
        read_known(in, component, (uint32_t)type, start->references.items, start->references.count, 1);
        read_largest(in, start->references.count);
    }
}

static void components(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->component_count = read_count(in);
    bundle->components = read_memory(in, bundle->component_count, sizeof *bundle->components);
    for (uint32_t k = 0; !in->bad && k < bundle->component_count; k++) {
        component_t *component = &bundle->components[k];
        component->bundle = bundle;
        component->name = read_text(in);
        component->folder = read_text(in);
        component->identifier = read_text(in);
        component->guid = read_text(in);
        component->flags = read_count(in);
        component->period = read_count(in);
        component->offset = read_count(in);
        component->length = read_real(in);
        component->tolerance = read_real(in);
        if (component->period == 0)
            in->bad = 1;
        if (component->flags & VERSION_3)
            read_arrays(in, component);
        starts(in, component);
        names(in, component);
    }
}

static set_t *settings(reader_t *in, const component_t *component, uint32_t *number, int initial)
{
    set_t *found;

    *number = read_count(in);
    found = read_memory(in, *number, sizeof *found);
    for (uint32_t k = 0; !in->bad && k < *number; k++) {
        set_t *set = &found[k];
        counts_t targets;
        if (initial)
            set->producer = read_count(in);
        read_limit(in, set->producer, in->bundle->component_count);
        set->type = read_count(in);
        read_limit(in, set->type, BUS_TYPES);
        targets = read_counts(in);
        set->count = targets.count;
        set->targets = targets.items;
        read_known(in, component, set->type, set->targets, set->count, 1);
        set->sources = read_positions(in, set->count);
        set->gains = read_reals(in, set->count);
        set->biases = read_reals(in, set->count);
        if (in->bad || (set->gains == NULL) != (set->biases == NULL)
            || (set->gains != NULL && set->type != REAL)) {
            in->bad = 1;
            break;
        }
        for (uint32_t n = 0; n < set->count; n++)
            read_limit(in, (uint32_t)set->sources[n], initial ? in->bundle->slot_count[set->type] : in->bundle->bus_size[set->type]);
        set->buffer = keep(in->bundle, set->count, sizes[set->type]);
        if (set->buffer == NULL)
            in->bad = 1;
        read_largest(in, set->count);
    }
    return found;
}

static get_t *fetches(reader_t *in, const component_t *component, uint32_t *number, int initial)
{
    get_t *found;

    *number = read_count(in);
    found = read_memory(in, *number, sizeof *found);
    for (uint32_t k = 0; !in->bad && k < *number; k++) {
        get_t *get = &found[k];
        counts_t references, used;
        uint32_t room;
        get->type = read_count(in);
        read_limit(in, get->type, BUS_TYPES);
        references = read_counts(in);
        get->start = read_count(in);
        used = read_counts(in);
        if (in->bad || used.count != references.count) {
            in->bad = 1;
            break;
        }
        get->count = references.count;
        get->references = references.items;
        read_known(in, component, get->type, get->references, get->count, 0);
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

static void ports(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->port_count = read_count(in);
    bundle->ports = read_memory(in, bundle->port_count, sizeof *bundle->ports);
    for (uint32_t k = 0; !in->bad && k < bundle->port_count; k++) {
        port_t *port = &bundle->ports[k];
        port->kind = read_count(in);
        read_limit(in, port->kind, TUNABLE + 1);
        port->type = read_count(in);
        read_limit(in, port->type, ALL_TYPES);
        if (port->kind == OUTPUT) {
            port->place = read_count(in);
            if (!in->bad && port->type != STRING)
                read_limit(in, port->place, bundle->row_size[port->type]);
        } else if (port->type == REAL)
            port->real_start = read_real(in);
        else if (port->type == STRING)
            port->text_start = read_text(in);
        else
            port->whole_start = (int32_t)read_count(in);
        port->target_count = read_count(in);
        port->targets = read_memory(in, port->target_count, sizeof *port->targets);
        for (uint32_t n = 0; !in->bad && n < port->target_count; n++) {
            target_t *target = &port->targets[n];
            target->component = read_count(in);
            read_limit(in, target->component, bundle->component_count);
            target->reference = read_count(in);
            target->gain = read_real(in);
            target->bias = read_real(in);
            if (!in->bad)
                read_known(in, &bundle->components[target->component], port->type, &target->reference, 1,
                      port->kind != OUTPUT);
        }
        if (port->kind == OUTPUT && port->target_count != 1)
            in->bad = 1;
    }
    read_largest(in, bundle->port_count);
}

/* What hosts see as variables: they are all ports, in their order. */
static void variables(reader_t *in)
{
    bundle_t *bundle = in->bundle;
    uint32_t first = 0;

    bundle->variable_count = read_count(in);
    bundle->variables = read_memory(in, bundle->variable_count, sizeof *bundle->variables);
    for (uint32_t k = 0; !in->bad && k < bundle->variable_count; k++) {
        variable_t *variable = &bundle->variables[k];
        variable->first = first;
        variable->count = read_count(in);
        variable->shown = read_count(in);
        read_limit(in, variable->shown, ENUMERATION + 1);
        if (variable->count == 0 || variable->count > bundle->port_count - first) {
            in->bad = 1;
            break;
        }
        first += variable->count;
        for (uint32_t n = variable->first; n < first; n++)
            if (bundle->ports[n].kind != bundle->ports[variable->first].kind
                || bundle->ports[n].type != (variable->shown == ENUMERATION ? INTEGER : variable->shown))
                in->bad = 1;
    }
    if (first != bundle->port_count)
        in->bad = 1;
}

static void operations(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->order = read_counts(in);
    if (bundle->order.count != bundle->component_count)
        in->bad = 1;
    for (uint32_t k = 0; !in->bad && k < bundle->component_count; k++) {
        component_t *component = &bundle->components[k];
        read_limit(in, bundle->order.items[k], bundle->component_count);
        component->initial_sets = settings(in, component, &component->initial_set_count, 1);
        for (uint32_t type = 0; !in->bad && type < BUS_TYPES; type++) {
            uint32_t total = 0; /* all of a type are set in one call */
            for (uint32_t n = 0; n < component->initial_set_count; n++)
                total += component->initial_sets[n].type == type ? component->initial_sets[n].count : 0;
            read_largest(in, total);
        }
        component->initial_gets = fetches(in, component, &component->initial_get_count, 1);
        component->initial_bus = fetches(in, component, &component->initial_bus_count, 0);
    }
    bundle->step_count = read_count(in);
    bundle->steps = read_memory(in, bundle->step_count, sizeof *bundle->steps);
    for (uint32_t k = 0; !in->bad && k < bundle->step_count; k++) {
        step_t *step = &bundle->steps[k];
        step->component = read_count(in);
        read_limit(in, step->component, bundle->component_count);
        if (in->bad)
            break;
        step->sets = settings(in, &bundle->components[step->component], &step->set_count, 0);
        step->gets = fetches(in, &bundle->components[step->component], &step->get_count, 0);
    }
}

static void ticks(reader_t *in)
{
    bundle_t *bundle = in->bundle;

    bundle->row_count = read_count(in);
    bundle->rows = read_memory(in, bundle->row_count, sizeof *bundle->rows);
    for (uint32_t k = 0; !in->bad && k < bundle->row_count; k++)
        for (int type = 0; !in->bad && type < BUS_TYPES; type++) {
            bundle->rows[k][type] = read_counts(in);
            if (bundle->rows[k][type].count != bundle->row_size[type])
                in->bad = 1;
            for (uint32_t n = 0; !in->bad && n < bundle->row_size[type]; n++)
                read_limit(in, bundle->rows[k][type].items[n], bundle->bus_size[type]);
        }
    bundle->cycle = read_count(in);
    bundle->ticks = read_memory(in, bundle->cycle, sizeof *bundle->ticks);
    for (uint32_t k = 0; !in->bad && k < bundle->cycle; k++) {
        tick_t *tick = &bundle->ticks[k];
        tick->early = read_counts(in);
        tick->late = read_counts(in);
        tick->row = read_count(in);
        read_limit(in, tick->row, bundle->row_count + 1);
        for (uint32_t n = 0; !in->bad && n < tick->early.count; n++)
            read_limit(in, tick->early.items[n], bundle->step_count);
        for (uint32_t n = 0; !in->bad && n < tick->late.count; n++)
            read_limit(in, tick->late.items[n], bundle->step_count);
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
        found[type] = read_count(in);
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
    if (size < sizeof magic - 1 || memcmp(read_bytes(&in, sizeof magic - 1), magic, sizeof magic - 1) != 0)
        return "resources/program.bin is not what the library needs";
    bundle->guid = read_text(&in);
    bundle->state.length = read_whole(&in);
    bundle->second = read_whole(&in);
    bundle->state.second = (double)bundle->second;
    bundle->step_ticks = read_count(&in);
    sized(&in, bundle->bus_size);
    sized(&in, bundle->slot_count);
    sized(&in, bundle->row_size);
    if (bundle->state.length <= 0 || bundle->second <= 0 || bundle->step_ticks == 0)
        in.bad = 1;
    components(&in);
    ports(&in);
    variables(&in);
    operations(&in);
    ticks(&in);
    buffers(&in);
    if (!in.bad && !make_operations(bundle))
        in.bad = 1;
    return in.bad ? "resources/program.bin is damaged, or there is no memory" : NULL;
}
