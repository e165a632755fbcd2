#include "plain_component.h"

int take_component_memory(Component *component, size_t own, size_t state)
{
    component->own = memory_take(&component->memory, 1, own);
    component->state = memory_take(&component->memory, 1, state);
    component->state_size = state;
    component->step_length = 0.0;
    return component->memory.failed ? refuse(component, "the host gives no memory") : 0;
}

int component_tuned(Component *component)
{
    (void)component;
    return 0;
}

int component_follow_inputs(Component *component)
{
    (void)component;
    return 0;
}

int component_evaluate(Component *component)
{
    (void)component;
    return 0;
}
