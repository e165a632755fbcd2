#include "values.h"

#include <stdlib.h>
#include <string.h>

#include "arrays.h"
#include "components.h"
#include "initialise.h"
#include "memory.h"
#include "messages.h"

static const char *const set_calls[2][ALL_TYPES] = {{"SetReal", "SetInteger", "SetBoolean", "SetString"},
                                                    {"SetFloat64", "SetInt32", "SetBoolean", "SetString"}};
static const char *const get_calls[2][ALL_TYPES] = {{"GetReal", "GetInteger", "GetBoolean", "GetString"},
                                                    {"GetFloat64", "GetInt32", "GetBoolean", "GetString"}};

const char *access_call(const component_t *component, int set, int type)
{
    return (set ? set_calls : get_calls)[(component->flags & VERSION_3) != 0][type];
}

fmi2Status set_values(component_t *component, int type, const uint32_t *references, size_t count, const void *values)
{
    if (component->flags & VERSION_3)
        return set_elements(component, type, references, count, values);
    return judge(component, access_call(component, 1, type),
                 component->call.set[type](component->instance, references, count, values));
}

fmi2Status get_values(component_t *component, int type, const uint32_t *references, size_t count, void *values)
{
    if (component->flags & VERSION_3)
        return get_elements(component, type, references, count, values);
    return judge(component, access_call(component, 0, type),
                 component->call.get[type](component->instance, references, count, values));
}

/* Values on the way to one component, in the scratch memory of the bundle. */
typedef struct {
    bundle_t *bundle;
    int type;
    uint32_t component;
    size_t count;
    fmi2Status worst;
} batch_t;

static void flush(batch_t *batch)
{
    bundle_t *bundle = batch->bundle;

    if (batch->count > 0 && batch->worst <= fmi2Warning)
        batch->worst = worse(batch->worst, set_values(&bundle->components[batch->component], batch->type,
                                                      bundle->references, batch->count, bundle->values));
    batch->count = 0;
}

static void send(batch_t *batch, const port_t *port, const target_t *target)
{
    bundle_t *bundle = batch->bundle;

    if (batch->count > 0 && (batch->component != target->component || batch->count == bundle->most_values))
        flush(batch);
    batch->component = target->component;
    bundle->references[batch->count] = target->reference;
    if (batch->type == REAL) {
        int plain = target->gain == 1.0 && target->bias == 0.0;
        ((double *)bundle->values)[batch->count] = plain ? port->real : target->gain * port->real + target->bias;
    } else if (batch->type == STRING)
        ((const char **)bundle->values)[batch->count] = port->text;
    else
        ((int32_t *)bundle->values)[batch->count] = port->whole;
    batch->count++;
}

static int store(port_t *port, const void *values, size_t k)
{
    if (port->type == REAL)
        port->real = ((const double *)values)[k];
    else if (port->type == STRING) {
        const char *given = ((const char *const *)values)[k];
        char *text = copy_text(given == NULL ? "" : given);
        if (text == NULL)
            return 0;
        free(port->text);
        port->text = text;
    } else
        port->whole = ((const int32_t *)values)[k];
    return 1;
}

static const char *const type_names[ALL_TYPES] = {"Real", "Integer", "Boolean", "String"};

static fmi2Status refuse_reference(const bundle_t *bundle, int type, fmi2ValueReference reference)
{
    return refuse(bundle, "value reference %u: there is no %s of this number", reference, type_names[type]);
}

fmi2Status refuse_set(const bundle_t *bundle, const port_t *port, uint32_t reference)
{
    if (port->kind == OUTPUT)
        return refuse(bundle, "value reference %u: is an output; only inputs and parameters can be set", reference);
    if (port->kind == PARAMETER && bundle->life > INITIALISING)
        return refuse(bundle, "value reference %u: is a fixed parameter; set it before initialization", reference);
    return fmi2OK;
}

fmi2Status set_ports(bundle_t *bundle, int type, const fmi2ValueReference references[], size_t count,
                     const void *values)
{
    batch_t batch = {bundle, type, 0, 0, fmi2OK};
    uint32_t most = 0;

    for (size_t k = 0; k < count; k++) {
        const port_t *port = references[k] < bundle->port_count ? &bundle->ports[references[k]] : NULL;
        if (port == NULL || (int)port->type != type)
            return refuse_reference(bundle, type, references[k]);
        if (refuse_set(bundle, port, references[k]) != fmi2OK)
            return fmi2Error;
        if (port->target_count > most)
            most = port->target_count;
    }
    for (size_t k = 0; k < count; k++) {
        port_t *port = &bundle->ports[references[k]];
        if (!store(port, values, k))
            return refuse(bundle, "value reference %u: there is no memory", references[k]);
        port->given = 1;
    }
    if (bundle->life == INSTANTIATED)
        return fmi2OK; /* components take them when they are initialised */
    bundle->propagated = 0;
    for (uint32_t n = 0; n < most; n++)
        for (size_t k = 0; k < count; k++)
            if (n < bundle->ports[references[k]].target_count)
                send(&batch, &bundle->ports[references[k]], &bundle->ports[references[k]].targets[n]);
    flush(&batch);
    return batch.worst;
}

fmi2Status set_given(bundle_t *bundle)
{
    batch_t batch = {bundle, REAL, 0, 0, fmi2OK};

    for (; batch.type < ALL_TYPES; batch.type++) {
        for (uint32_t k = 0; k < bundle->port_count; k++) {
            const port_t *port = &bundle->ports[k];
            for (uint32_t n = 0; port->given && (int)port->type == batch.type && n < port->target_count; n++)
                send(&batch, port, &port->targets[n]);
        }
        flush(&batch);
    }
    return batch.worst;
}

int start_ports(bundle_t *bundle)
{
    for (uint32_t k = 0; k < bundle->port_count; k++) {
        port_t *port = &bundle->ports[k];
        port->given = 0;
        port->real = port->real_start;
        port->whole = port->whole_start;
        if (port->type == STRING) {
            free(port->text);
            port->text = copy_text(port->text_start == NULL ? "" : port->text_start);
            if (port->text == NULL)
                return 0;
        }
    }
    return 1;
}

void free_ports(bundle_t *bundle)
{
    for (uint32_t k = 0; k < bundle->port_count && bundle->ports != NULL; k++)
        free(bundle->ports[k].text);
}

/* Whether a port shows a sample that would be taken at this tick, but for the end of the simulation. */
static int waits(const bundle_t *bundle, const port_t *port)
{
    const component_t *component = &bundle->components[port->targets[0].component];
    int64_t since = bundle->state.tick - (int64_t)component->offset;

    return port->kind == OUTPUT && port->type != STRING && (component->flags & EARLY) != 0
           && since % (int64_t)component->period == 0;
}

void take_last_row(bundle_t *bundle)
{
    double *kept = bundle->values;

    for (uint32_t k = 0; k < bundle->port_count; k++)
        if (waits(bundle, &bundle->ports[k]))
            memcpy(&kept[k], (char *)bundle->row[bundle->ports[k].type]
                   + bundle->ports[k].place * sizes[bundle->ports[k].type], sizes[bundle->ports[k].type]);
    take_row(bundle);
    for (uint32_t k = 0; k < bundle->port_count; k++)
        if (waits(bundle, &bundle->ports[k]))
            memcpy((char *)bundle->row[bundle->ports[k].type]
                   + bundle->ports[k].place * sizes[bundle->ports[k].type], &kept[k], sizes[bundle->ports[k].type]);
}

void take_row(bundle_t *bundle)
{
    const tick_t *tick = &bundle->ticks[bundle->state.tick % bundle->cycle];
    const counts_t *row = tick->row == 0 ? NULL : bundle->rows[tick->row - 1];
    const double *reals = bundle->bus[REAL];

    if (row == NULL)
        return;
    for (uint32_t k = 0; k < row[REAL].count; k++)
        ((double *)bundle->row[REAL])[k] = reals[row[REAL].items[k]];
    for (int type = INTEGER; type < BUS_TYPES; type++)
        for (uint32_t k = 0; k < row[type].count; k++)
            ((int32_t *)bundle->row[type])[k] = ((const int32_t *)bundle->bus[type])[row[type].items[k]];
}

static fmi2Status fetch_of(bundle_t *bundle, uint32_t component, int type)
{
    size_t count = 0;
    fmi2Status status;

    for (uint32_t k = 0; k < bundle->port_count; k++) {
        const port_t *port = &bundle->ports[k];
        if (port->kind == OUTPUT && (int)port->type == type && port->targets[0].component == component)
            bundle->references[count++] = port->targets[0].reference;
    }
    if (count == 0)
        return fmi2OK;
    status = get_values(&bundle->components[component], type, bundle->references, count, bundle->values);
    if (status > fmi2Warning)
        return status;
    count = 0;
    for (uint32_t k = 0; k < bundle->port_count; k++) {
        const port_t *port = &bundle->ports[k];
        if (port->kind != OUTPUT || (int)port->type != type || port->targets[0].component != component)
            continue;
        if (type == REAL)
            ((double *)bundle->row[type])[port->place] = ((const double *)bundle->values)[count++];
        else
            ((int32_t *)bundle->row[type])[port->place] = ((const int32_t *)bundle->values)[count++];
    }
    return status;
}

fmi2Status fetch_outputs(bundle_t *bundle)
{
    fmi2Status worst = fmi2OK;

    for (uint32_t component = 0; component < bundle->component_count; component++)
        for (int type = 0; type < BUS_TYPES && worst <= fmi2Warning; type++)
            worst = worse(worst, fetch_of(bundle, component, type));
    return worst;
}

fmi2Status get_ports(bundle_t *bundle, int type, const fmi2ValueReference references[], size_t count, void *values)
{
    fmi2Status worst = fmi2OK;
    int outputs = 0;

    for (size_t k = 0; k < count; k++) {
        const port_t *port = references[k] < bundle->port_count ? &bundle->ports[references[k]] : NULL;
        if (port == NULL || (int)port->type != type)
            return refuse_reference(bundle, type, references[k]);
        outputs |= port->kind == OUTPUT;
    }
    if (outputs && bundle->life <= INITIALISING) {
        worst = bundle->life == INITIALISING ? propagate(bundle) : fmi2OK;
        if (worst <= fmi2Warning)
            worst = worse(worst, fetch_outputs(bundle));
        if (worst > fmi2Warning)
            return worst;
    }
    for (size_t k = 0; k < count; k++) {
        const port_t *port = &bundle->ports[references[k]];
        if (type == STRING) {
            const char **text = &((const char **)values)[k];
            component_t *component = port->kind == OUTPUT ? &bundle->components[port->targets[0].component] : NULL;
            *text = port->text;
            if (component != NULL)
                worst = worse(worst, get_values(component, STRING, &port->targets[0].reference, 1, (void *)text));
        } else if (type == REAL)
            ((double *)values)[k] = port->kind == OUTPUT ? ((double *)bundle->row[REAL])[port->place] : port->real;
        else
            ((int32_t *)values)[k] = port->kind == OUTPUT ? ((int32_t *)bundle->row[type])[port->place] : port->whole;
    }
    return worst;
}
