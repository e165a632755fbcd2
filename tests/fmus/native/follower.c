/* A toy with outputs that follow inputs: y[1] = x + gain u[1] u[2], y[2] = |u[1]|, where x, from `begin` on, sums u[2]
over the steps. No run starts with u[1] below 0. */
#include "component.h"
#include "ports.h"

#include <math.h>

static int follow(Component *component)
{
    const double *u = component->real + PORT_U, *x = (const double *)(const void *)component->state;

    component->real[PORT_X] = *x;
    component->real[PORT_Y] = *x + component->real[PORT_GAIN] * u[0] * u[1];
    component->real[PORT_Y + 1] = fabs(u[0]);
    return 0;
}

int component_start(Component *component)
{
    component->state = memory_take(&component->memory, 1, sizeof(double));
    component->state_size = sizeof(double);
    if (component->memory.failed)
        return refuse(component, "no memory");
    if (component->real[PORT_U] < 0.0)
        return refuse(component, "u[1] must be >= 0 at the start");
    *(double *)(void *)component->state = component->real[PORT_BEGIN];
    return follow(component);
}

int component_first_step(Component *component, double length)
{
    component->step_length = length;
    return 0;
}

int component_advance(Component *component, double time, double step)
{
    (void)time;
    *(double *)(void *)component->state += step * component->real[PORT_U + 1];
    return follow(component);
}

int component_tuned(Component *component) { return follow(component); }

int component_follow_inputs(Component *component) { return follow(component); }

int component_differentiate(Component *component, const double *seed, double *change)
{
    const double *u = component->real + PORT_U, *s = seed + PORT_U;

    change[PORT_Y] = component->real[PORT_GAIN] * (u[0] * s[1] + u[1] * s[0]);
    change[PORT_Y + 1] = u[0] > 0.0 || (u[0] == 0.0 && s[0] > 0.0) ? s[0] : -s[0];
    return 0;
}

int component_evaluate(Component *component)
{
    (void)component;
    return 0;
}

int component_restored(Component *component) { return follow(component); }
