#include "program_arrays.h"

#include "memory.h"

void *read_values(reader_t *in, int type, uint32_t count)
{
    void *found = in->bad ? NULL : keep(in->bundle, count, sizes[type]);

    if (found == NULL)
        in->bad = 1;
    for (uint32_t k = 0; !in->bad && k < count; k++)
        if (type == REAL)
            ((double *)found)[k] = read_real(in);
        else if (type == STRING)
            ((const char **)found)[k] = read_text(in);
        else
            ((int32_t *)found)[k] = (int32_t)read_count(in);
    return found;
}

/* Read the arrays of one type: for each its value reference, the reference of its first element, and its size. */
static void arrays_of(reader_t *in, component_t *component, uint32_t type)
{
    arrays_t *arrays = &component->arrays[type];
    counts_t handles = read_counts(in), firsts = read_counts(in), lengths = read_counts(in);
    uint32_t size = 0;

    arrays->settable = read_count(in);
    if (in->bad || firsts.count != handles.count || lengths.count != handles.count) {
        in->bad = 1;
        return;
    }
    for (uint32_t k = 0; !in->bad && k < lengths.count; k++)
        if (lengths.items[k] > component->element_count - size
            || firsts.items[k] > component->element_count - lengths.items[k])
            in->bad = 1;
        else
            size += lengths.items[k];
    if (in->bad || arrays->settable > size) {
        in->bad = 1;
        return;
    }
    arrays->count = handles.count;
    arrays->handles = handles.items;
    arrays->begins = keep(in->bundle, (size_t)arrays->count + 1, sizeof *arrays->begins);
    arrays->array_of = keep(in->bundle, size, sizeof *arrays->array_of);
    arrays->touched = keep(in->bundle, (size_t)arrays->count + 1, 1);
    arrays->memory = keep(in->bundle, size, sizes[type]);
    arrays->fetched = keep(in->bundle, size, sizes[type]);
    if (arrays->begins == NULL || arrays->array_of == NULL || arrays->touched == NULL || arrays->memory == NULL
        || arrays->fetched == NULL) {
        in->bad = 1;
        return;
    }
    for (uint32_t k = 0; k < arrays->count; k++) {
        arrays->begins[k + 1] = arrays->begins[k] + lengths.items[k];
        for (uint32_t n = 0; n < lengths.items[k]; n++) {
            element_t *element = &component->elements[firsts.items[k] + n];
            element->type = type;
            element->position = arrays->begins[k] + n;
            arrays->array_of[element->position] = k;
        }
    }
    arrays->starts = read_values(in, (int)type, arrays->settable);
}

void read_arrays(reader_t *in, component_t *component)
{
    component->element_count = read_count(in);
    read_limit(in, component->element_count, UINT32_MAX / 64);
    component->elements = in->bad ? NULL : keep(in->bundle, component->element_count, sizeof *component->elements);
    if (component->elements == NULL)
        in->bad = 1;
    for (uint32_t k = 0; !in->bad && k < component->element_count; k++)
        component->elements[k].type = ALL_TYPES;
    for (uint32_t type = 0; !in->bad && type < ALL_TYPES; type++)
        arrays_of(in, component, type);
}

void read_known(reader_t *in, const component_t *component, uint32_t type, const uint32_t *references, uint32_t count,
                int set)
{
    for (uint32_t k = 0; !in->bad && (component->flags & VERSION_3) != 0 && k < count; k++)
        if (references[k] >= component->element_count || component->elements[references[k]].type != type
            || (set && component->elements[references[k]].position >= component->arrays[type].settable))
            in->bad = 1;
}
