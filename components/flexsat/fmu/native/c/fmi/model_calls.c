/* Calls of the component that several functions of FMI need. */
#include "instance.h"

Status check_outputs(Instance *instance, const char *call)
{
    const int place = output_not_finite(&instance->component, port_table.real_outputs);
    char name[REASON_SIZE], value[NUMBER_SIZE];

    if (place < 0)
        return CALL_OK;
    return refuse_call(instance, call, "output %s = %s is not finite", variable_name(port_at(REAL, place), place, name),
                       number_text(instance->component.real[place], value));
}

int start_component(Instance *instance)
{
    Component *component = &instance->component;

    memory_release(&component->memory);
    component->own = NULL;
    component->state = NULL;
    component->state_size = 0;
    component->step_length = 0.0;
    component->message[0] = '\0';
    if (component_start(component))
        return 0;
    if (component->memory.failed)
        return !refuse(component, "there is no memory for the model");
    instance->fixed_step = component->step_length;
    instance->length = 0.0;
    return 1;
}

Status start_model(Instance *instance, const char *call)
{
    if (instance->started)
        return CALL_OK;
    if (!start_component(instance))
        return refuse_for_model(instance, call);
    instance->started = instance->stale = instance->inputs_set = 1;
    return check_outputs(instance, call);
}

Status compute_outputs(Instance *instance, const char *call, int flags)
{
    Component *component = &instance->component;

    if (flags & ON_DEMAND && instance->stale) {
        if (component_evaluate(component))
            return refuse_for_model(instance, call);
        instance->stale = 0;
        if (check_outputs(instance, call) != CALL_OK)
            return CALL_ERROR;
    }
    if (flags & FOLLOWS_INPUTS && instance->inputs_set) {
        if (component_follow_inputs(component))
            return refuse_for_model(instance, call);
        instance->inputs_set = 0;
        return check_outputs(instance, call);
    }
    return CALL_OK;
}
