/* The life of an instance: made, initialised, stepped, ended, reset, freed. */
#include "identity.h"
#include "instance.h"

#include <math.h>
#include <string.h>

static int is_blank(const char *text) { return text == NULL || text[strspn(text, " \t\r\n\v\f")] == '\0'; }

/* Make the arrays of the values; they live as long as the instance. */
static int make_values(Instance *instance)
{
    Component *component = &instance->component;
    Memory *memory = &instance->memory;
    const size_t strings = (size_t)port_table.counts[STRING];
    char *texts = memory_take(memory, strings, STRING_SIZE);
    size_t k;

    instance->values_before = memory_take(memory, values_size(), 1);
    component->real = memory_doubles(memory, (size_t)port_table.counts[REAL]);
    if (port_table.differentiate != NULL) {
        instance->seed = memory_doubles(memory, (size_t)port_table.counts[REAL]);
        instance->change = memory_doubles(memory, (size_t)port_table.counts[REAL]);
    }
    component->integer = memory_take(memory, (size_t)port_table.counts[INTEGER], sizeof(int));
    component->boolean = memory_take(memory, (size_t)port_table.counts[BOOLEAN], sizeof(int));
    component->string = memory_take(memory, strings, sizeof(char *));
    if (memory->failed)
        return 0;
    for (k = 0; k < strings; k++)
        component->string[k] = texts + k * STRING_SIZE;
    return 1;
}

/* Return an instance, or NULL if there is no memory. */
static Instance *make(const char *name, Memory memory, const Host *host)
{
    Instance *instance = memory.allocate(1, sizeof *instance);

    if (instance == NULL)
        return NULL;
    memset(instance, 0, sizeof *instance);
    instance->memory = instance->component.memory = memory;
    instance->host = *host;
    instance->name = memory_take(&instance->memory, strlen(name) + 1, 1);
    if (instance->name == NULL || !make_values(instance)) {
        memory_release(&instance->memory);
        memory.release(instance);
        return NULL;
    }
    strcpy(instance->name, name);
    return instance;
}

Instance *instantiate(const char *call, const char *name, const char *guid, const char *known_as, Memory memory,
                      const Host *host)
{
    const char *known = is_blank(name) ? "" : name;
    Instance *instance;

    if (is_blank(name))
        log_to_host(host, known, CALL_ERROR, "%s: the instance has no name", call);
    else if (guid == NULL)
        log_to_host(host, known, CALL_ERROR, "%s: the %s is NULL", call, known_as);
    else if (strcmp(guid, this_fmu.guid) != 0)
        log_to_host(host, known, CALL_ERROR,
                    "%s: the %s %.100s is not that of this FMU, %s; read the model description again", call, known_as,
                    guid, this_fmu.guid);
    else {
        instance = make(name, memory, host);
        if (instance != NULL) {
            begin_anew(instance);
            return instance;
        }
        log_to_host(host, known, CALL_ERROR, "%s: there is no memory for the instance", call);
    }
    return NULL;
}

void begin_anew(Instance *instance)
{
    Component *component = &instance->component;

    memory_release(&component->memory);
    component->own = NULL;
    component->state = NULL;
    component->state_size = 0;
    component->step_length = component->start_time = 0.0;
    set_start_values(component);
    instance->phase = INSTANTIATED;
    instance->set_up = instance->ends = instance->started = instance->stale = instance->inputs_set = 0;
    instance->present = instance->stop = instance->fixed_step = instance->length = 0.0;
    instance->failure[0] = '\0';
}

void free_instance(Instance *instance)
{
    void (*release)(void *);

    if (instance == NULL)
        return;
    release = instance->memory.release;
    free_states(instance);
    memory_release(&instance->component.memory);
    memory_release(&instance->memory);
    release(instance);
}

Status choose_categories(Instance *instance, size_t n, const char *const categories[])
{
    static const char call[] = "setDebugLogging";
    Status status = CALL_OK;
    size_t k;

    if (n > 0 && categories == NULL)
        return refuse_call(instance, call, "%lu categories in a NULL array", (unsigned long)n);
    for (k = 0; k < n; k++)
        if (categories[k] == NULL)
            return refuse_call(instance, call, "category %lu is NULL", (unsigned long)k + 1);
    for (k = 0; k < n; k++)
        if (strcmp(categories[k], CATEGORY) != 0) {
            log_to_host(&instance->host, instance->name, CALL_WARNING, "%s: no category %.200s; there is " CATEGORY,
                        call, categories[k]);
            status = CALL_WARNING;
        }
    return status;
}

Status set_experiment(Instance *instance, const char *call, int tolerant, double tolerance, double start, int ends,
                      double stop)
{
    char first[NUMBER_SIZE], second[NUMBER_SIZE];

    if (!isfinite(start))
        return refuse_call(instance, call, "the start time must be finite, got %s s", number_text(start, first));
    if (ends && !(isfinite(stop) && stop >= start))
        return refuse_call(instance, call,
                           "the stop time must be finite and not before the start time %s s, got %s s",
                           number_text(start, first), number_text(stop, second));
    if (tolerant && !(isfinite(tolerance) && tolerance >= 0.0))
        return refuse_call(instance, call, "the tolerance must be finite and >= 0, got %s",
                           number_text(tolerance, first));
    instance->present = instance->component.start_time = start;
    instance->stop = ends ? stop : 0.0;
    instance->ends = ends != 0;
    instance->set_up = 1;
    instance->started = 0;
    return CALL_OK;
}

Status exit_initialization(Instance *instance)
{
    static const char call[] = "exitInitializationMode";

    if (check_order(instance, EXIT_INITIALIZATION, call) != CALL_OK || start_model(instance, call) != CALL_OK)
        return CALL_ERROR;
    instance->phase = STEPPING;
    return CALL_OK;
}

Status terminate(Instance *instance)
{
    if (check_order(instance, TERMINATE, "terminate") != CALL_OK)
        return CALL_ERROR;
    instance->phase = TERMINATED;
    return CALL_OK;
}

/* Write the name of the call for a message: the one with the time. */
static const char *step_at(double time, char name[REASON_SIZE])
{
    char text[NUMBER_SIZE];

    strcpy(name, "doStep at t = ");
    strcat(strcat(name, number_text(time, text)), " s");
    return name;
}

Status make_step(Instance *instance, double time, double step)
{
    char name[REASON_SIZE], reason[REASON_SIZE];
    double length;

    if (instance->phase != STEPPING)
        return check_order(instance, DO_STEP, step_at(time, name));
    if (!admit_step(instance, time, step, &length, reason))
        return refuse_call(instance, step_at(time, name), "%s", reason);
    instance->stale = 1;
    if (component_advance(&instance->component, time, length))
        return refuse_for_model(instance, step_at(time, name));
    if (output_not_finite(&instance->component, port_table.stepped_outputs) >= 0)
        return check_outputs(instance, step_at(time, name));
    instance->inputs_set = 0;
    instance->present = time + step;
    return CALL_OK;
}
