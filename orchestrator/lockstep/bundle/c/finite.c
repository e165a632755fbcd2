#include "finite.h"

#include "messages.h"

fmi2Status check_converted(const component_t *component, const set_t *set, const double *values)
{
    for (uint32_t k = 0; k < set->count; k++)
        if (!is_finite(values[k]))
            return refuse(component->bundle, "%s: the input of reference %u is %g at %.9g s after the conversion of its "
                          "connection; every exchanged value must be finite", component->name, set->targets[k],
                          values[k], time_now(component->bundle));
    return fmi2OK;
}

fmi2Status check_finite(const component_t *component, const get_t *get, const double *values, int64_t tick)
{
    double sum = 0.0;

    for (uint32_t k = 0; k < get->count; k++)
        sum += values[k] - values[k];
    if (sum == 0.0)
        return fmi2OK;
    for (uint32_t k = 0; k < get->count; k++)
        if (!get->unused[k] && !is_finite(values[k]))
            return refuse(component->bundle, "%s: the output of reference %u is %g at %.9g s; every exchanged value must "
                          "be finite", component->name, get->references[k], values[k],
                          time_of(component->bundle, tick));
    return fmi2OK;
}
