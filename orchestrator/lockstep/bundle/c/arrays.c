#include "arrays.h"

#include <stdlib.h>
#include <string.h>

#include "components.h"
#include "memory.h"
#include "messages.h"
#include "values.h"

const size_t array_sizes[ALL_TYPES] = {sizeof(fmi3Float64), sizeof(fmi3Int32), sizeof(fmi3Boolean), sizeof(fmi3String)};

void free_arrays(component_t *component)
{
    arrays_t *texts = &component->arrays[STRING];

    for (uint32_t k = 0; texts->memory != NULL && k < texts->settable; k++) {
        free(((char **)texts->memory)[k]);
        ((char **)texts->memory)[k] = NULL;
    }
}

int start_arrays(component_t *component)
{
    free_arrays(component);
    for (int type = 0; type < ALL_TYPES; type++) {
        arrays_t *arrays = &component->arrays[type];
        for (uint32_t k = 0; k < arrays->settable; k++)
            if (type == REAL)
                ((double *)arrays->memory)[k] = ((double *)arrays->starts)[k];
            else if (type == INTEGER)
                ((int32_t *)arrays->memory)[k] = ((int32_t *)arrays->starts)[k];
            else if (type == BOOLEAN)
                ((fmi3Boolean *)arrays->memory)[k] = ((int32_t *)arrays->starts)[k] != 0;
            else {
                char *text = copy_text(((const char **)arrays->starts)[k]);
                if (text == NULL)
                    return 0;
                ((char **)arrays->memory)[k] = text;
            }
    }
    return 1;
}

void touch_arrays(const component_t *component, int type, const uint32_t *references, size_t count)
{
    const arrays_t *arrays = &component->arrays[type];

    for (size_t k = 0; k < count; k++)
        arrays->touched[arrays->array_of[component->elements[references[k]].position]] = 1;
}

int next_run(const arrays_t *arrays, uint32_t *array, uint32_t *end)
{
    uint32_t k = *array;

    while (k < arrays->count && !arrays->touched[k])
        k++;
    *array = k;
    for (; k < arrays->count && arrays->touched[k]; k++)
        arrays->touched[k] = 0;
    *end = k;
    return *array < *end;
}

/* Keep one value in the memory of what can be set. Return 0 if there is no memory. */
static int store(const arrays_t *arrays, int type, uint32_t position, const void *values, size_t k)
{
    if (type == REAL)
        ((double *)arrays->memory)[position] = ((const double *)values)[k];
    else if (type == INTEGER)
        ((int32_t *)arrays->memory)[position] = ((const int32_t *)values)[k];
    else if (type == BOOLEAN)
        ((fmi3Boolean *)arrays->memory)[position] = ((const int32_t *)values)[k] != 0;
    else {
        char *text = copy_text(((const char *const *)values)[k]);
        if (text == NULL)
            return 0;
        free(((char **)arrays->memory)[position]);
        ((char **)arrays->memory)[position] = text;
    }
    return 1;
}

fmi2Status set_elements(component_t *component, int type, const uint32_t *references, size_t count, const void *values)
{
    arrays_t *arrays = &component->arrays[type];
    fmi2Status worst = fmi2OK;
    uint32_t array = 0, end;

    for (size_t k = 0; k < count; k++)
        if (!store(arrays, type, component->elements[references[k]].position, values, k))
            return refuse(component->bundle, "%s: there is no memory", component->name);
    touch_arrays(component, type, references, count);
    for (; next_run(arrays, &array, &end); array = end) {
        const uint32_t first = arrays->begins[array];
        const char *memory = (const char *)arrays->memory + first * array_sizes[type];
        if (worst <= fmi2Warning)
            worst = worse(worst, judge(component, access_call(component, 1, type),
                                       (fmi2Status)component->call.set3[type](component->instance,
                                                                              &arrays->handles[array], end - array,
                                                                              memory, arrays->begins[end] - first)));
    }
    return worst;
}

fmi2Status get_elements(component_t *component, int type, const uint32_t *references, size_t count, void *values)
{
    arrays_t *arrays = &component->arrays[type];
    fmi2Status worst = fmi2OK;
    uint32_t array = 0, end;

    touch_arrays(component, type, references, count);
    for (; next_run(arrays, &array, &end); array = end) {
        const uint32_t first = arrays->begins[array];
        char *fetched = (char *)arrays->fetched + first * array_sizes[type];
        if (worst <= fmi2Warning)
            worst = worse(worst, judge(component, access_call(component, 0, type),
                                       (fmi2Status)component->call.get3[type](component->instance,
                                                                              &arrays->handles[array], end - array,
                                                                              fetched, arrays->begins[end] - first)));
    }
    for (size_t k = 0; worst <= fmi2Warning && k < count; k++) {
        const uint32_t position = component->elements[references[k]].position;
        if (type == REAL)
            ((double *)values)[k] = ((double *)arrays->fetched)[position];
        else if (type == INTEGER)
            ((int32_t *)values)[k] = ((int32_t *)arrays->fetched)[position];
        else if (type == BOOLEAN)
            ((int32_t *)values)[k] = ((fmi3Boolean *)arrays->fetched)[position];
        else
            ((const char **)values)[k] = ((const char **)arrays->fetched)[position];
    }
    return worst;
}
