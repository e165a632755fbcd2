/* The life of an instance: made, initialised, stepped, ended, reset, freed. */
#include "identity.h"
#include "instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *FMI2(fmi2GetTypesPlatform)(void) { return "default"; }

const char *FMI2(fmi2GetVersion)(void) { return "2.0"; }

static int is_blank(fmi2String text) { return text == NULL || text[strspn(text, " \t\r\n\v\f")] == '\0'; }

/* Make the arrays of the values; they live as long as the instance. */
static int make_values(Instance *instance)
{
    Component *component = &instance->component;
    Memory *memory = &instance->memory;
    char *texts = memory_take(memory, STRING_COUNT, STRING_SIZE);
    int k;

    component->real = memory_doubles(memory, REAL_COUNT);
    component->integer = memory_take(memory, INTEGER_COUNT, sizeof(int));
    component->boolean = memory_take(memory, BOOLEAN_COUNT, sizeof(int));
    component->string = memory_take(memory, STRING_COUNT, sizeof(char *));
    if (memory->failed)
        return 0;
    for (k = 0; k < STRING_COUNT; k++)
        component->string[k] = texts + (size_t)k * STRING_SIZE;
    return 1;
}

/* Return an instance, or NULL if there is no memory. */
static Instance *make(fmi2String name, const fmi2CallbackFunctions *functions)
{
    const int by_host = functions != NULL && functions->allocateMemory != NULL && functions->freeMemory != NULL;
    Memory memory = {calloc, free, NULL, 0};
    Instance *instance;

    if (by_host) {
        memory.allocate = functions->allocateMemory;
        memory.release = functions->freeMemory;
    }
    instance = memory.allocate(1, sizeof *instance);
    if (instance == NULL)
        return NULL;
    memset(instance, 0, sizeof *instance);
    instance->memory = instance->component.memory = memory;
    if (functions != NULL)
        instance->host = *functions;
    instance->name = memory_take(&instance->memory, strlen(name) + 1, 1);
    if (instance->name == NULL || !make_values(instance)) {
        memory_release(&instance->memory);
        memory.release(instance);
        return NULL;
    }
    strcpy(instance->name, name);
    return instance;
}

static void begin_anew(Instance *instance)
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

fmi2Component FMI2(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                    const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    const char *known = is_blank(name) ? "" : name;
    Instance *instance;

    (void)resources; /* there are none */
    (void)visible;
    (void)logging; /* only refusals are logged, and always */
    if (is_blank(name))
        log_to_host(functions, known, fmi2Error, "fmi2Instantiate: the instance has no name");
    else if (type != fmi2CoSimulation)
        log_to_host(functions, known, fmi2Error, "fmi2Instantiate: this FMU is for co-simulation only");
    else if (guid == NULL)
        log_to_host(functions, known, fmi2Error, "fmi2Instantiate: the GUID is NULL");
    else if (strcmp(guid, MODEL_GUID) != 0)
        log_to_host(functions, known, fmi2Error,
                    "fmi2Instantiate: the GUID %.100s is not that of this FMU, " MODEL_GUID
                    "; read the model description again",
                    guid);
    else {
        instance = make(name, functions);
        if (instance != NULL) {
            begin_anew(instance);
            return instance;
        }
        log_to_host(functions, known, fmi2Error, "fmi2Instantiate: there is no memory for the instance");
    }
    return NULL;
}

void FMI2(fmi2FreeInstance)(fmi2Component c)
{
    Instance *instance = c;
    void (*release)(void *);

    if (instance == NULL)
        return;
    release = instance->memory.release;
    free_states(instance);
    memory_release(&instance->component.memory);
    memory_release(&instance->memory);
    release(instance);
}

fmi2Status FMI2(fmi2Reset)(fmi2Component c)
{
    if (c == NULL)
        return fmi2Error;
    begin_anew(c);
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    static const char call[] = "setDebugLogging";
    Instance *instance = c;
    fmi2Status status = fmi2OK;
    size_t k;

    (void)on; /* only refusals are logged, and always */
    if (instance == NULL)
        return fmi2Error;
    if (n > 0 && categories == NULL)
        return refuse_call(instance, call, "%lu categories in a NULL array", (unsigned long)n);
    for (k = 0; k < n; k++)
        if (categories[k] == NULL)
            return refuse_call(instance, call, "category %lu is NULL", (unsigned long)k + 1);
    for (k = 0; k < n; k++)
        if (strcmp(categories[k], CATEGORY) != 0) {
            log_to_host(&instance->host, instance->name, fmi2Warning, "%s: no category %.200s; there is " CATEGORY, call,
                        categories[k]);
            status = fmi2Warning;
        }
    return status;
}

fmi2Status FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                                     fmi2Boolean ends, fmi2Real stop)
{
    static const char call[] = "setupExperiment";
    Instance *instance = c;
    char first[NUMBER_SIZE], second[NUMBER_SIZE];

    if (instance == NULL)
        return fmi2Error;
    if (check_order(instance, SETUP_EXPERIMENT, call) != fmi2OK)
        return fmi2Error;
    if (!isfinite(start))
        return refuse_call(instance, call, "the start time must be finite, got %s s", number_text(start, first));
    if (ends && !(isfinite(stop) && stop >= start))
        return refuse_call(instance, call,
                           "the stop time must be finite and not before the start time %s s, got %s s",
                           number_text(start, first), number_text(stop, second));
    if (defined && !(isfinite(tolerance) && tolerance >= 0.0))
        return refuse_call(instance, call, "the tolerance must be finite and >= 0, got %s",
                           number_text(tolerance, first));
    instance->present = instance->component.start_time = start;
    instance->stop = ends ? stop : 0.0;
    instance->ends = ends != 0;
    instance->set_up = 1;
    instance->started = 0;
    return fmi2OK;
}

fmi2Status FMI2(fmi2EnterInitializationMode)(fmi2Component c)
{
    static const char call[] = "enterInitializationMode";
    Instance *instance = c;

    if (instance == NULL)
        return fmi2Error;
    if (check_order(instance, ENTER_INITIALIZATION, call) != fmi2OK)
        return fmi2Error;
    if (!instance->set_up)
        return refuse_call(instance, call, "not allowed before fmi2SetupExperiment");
    instance->phase = INITIALIZING;
    return fmi2OK;
}

fmi2Status FMI2(fmi2ExitInitializationMode)(fmi2Component c)
{
    static const char call[] = "exitInitializationMode";
    Instance *instance = c;

    if (instance == NULL)
        return fmi2Error;
    if (check_order(instance, EXIT_INITIALIZATION, call) != fmi2OK || start_model(instance, call) != fmi2OK)
        return fmi2Error;
    instance->phase = STEPPING;
    return fmi2OK;
}

fmi2Status FMI2(fmi2Terminate)(fmi2Component c)
{
    Instance *instance = c;

    if (instance == NULL || check_order(instance, TERMINATE, "terminate") != fmi2OK)
        return fmi2Error;
    instance->phase = TERMINATED;
    return fmi2OK;
}

/* Write the name of the call for a message: the one with the time. */
static const char *step_at(double time, char name[REASON_SIZE])
{
    char text[NUMBER_SIZE];

    strcpy(name, "doStep at t = ");
    strcat(strcat(name, number_text(time, text)), " s");
    return name;
}

fmi2Status FMI2(fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state_prior)
{
    Instance *instance = c;
    char name[REASON_SIZE], reason[REASON_SIZE];
    double length;

    (void)no_set_state_prior;
    if (instance == NULL)
        return fmi2Error;
    if (instance->phase != STEPPING)
        return check_order(instance, DO_STEP, step_at(time, name));
    if (!admit_step(instance, time, step, &length, reason))
        return refuse_call(instance, step_at(time, name), "%s", reason);
    instance->stale = 1;
    if (component_advance(&instance->component, time, length))
        return refuse_for_model(instance, step_at(time, name));
    if (output_not_finite(&instance->component) >= 0)
        return check_outputs(instance, step_at(time, name));
    instance->inputs_set = 0;
    instance->present = time + step;
    return fmi2OK;
}
