#include "finite.h"

#include "messages.h"

/* Return the name of a Real that a connection transfers. */
static const char *name_of(const component_t *component, uint32_t reference)
{
    const names_t *names = &component->names[REAL];

    for (uint32_t k = 0; k < names->references.count; k++)
        if (names->references.items[k] == reference)
            return names->texts[k];
    return "?";
}

fmi2Status refuse_converted(const component_t *component, uint32_t target, double value)
{
    return refuse(component->bundle, "%s.%s: is %g at %.9g s after the conversion of its connection; every exchanged "
                  "value must be finite", component->name, name_of(component, target), value,
                  time_now(component->bundle));
}

fmi2Status check_converted(const component_t *component, const set_t *set, const double *values)
{
    for (uint32_t k = 0; k < set->count; k++)
        if (!is_finite(values[k]))
            return refuse_converted(component, set->targets[k], values[k]);
    return fmi2OK;
}

fmi2Status check_finite(const component_t *component, const get_t *get, const double *values, int64_t tick)
{
    for (uint32_t k = 0; k < get->count; k++)
        if (!get->unused[k] && !is_finite(values[k]))
            return refuse(component->bundle, "%s.%s: is %g at %.9g s; every exchanged value must be finite",
                          component->name, name_of(component, get->references[k]), values[k],
                          time_of(component->bundle, tick));
    return fmi2OK;
}
