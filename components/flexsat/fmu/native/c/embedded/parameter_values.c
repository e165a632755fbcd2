#include "parameter_values.h"

#include <string.h>

#include "number_text.h"
#include "parameter_table.h"
#include "ports.h"

static int read_reals(Component *component, const ParameterEntry *entry, const unsigned char *from)
{
    double *values = component->real + entry->place;
    char text[NUMBER_SIZE];
    int k;

    memcpy(values, from, (size_t)entry->size * sizeof(double));
    for (k = 0; k < entry->size; k++)
        if (!(values[k] >= entry->least && values[k] <= entry->greatest)) /* the negation catches not-a-number too */
            return refuse(component, "parameter %s must lie within its limits, got %s", entry->name,
                          number_text(values[k], text));
    return 0;
}

static int read_choice(Component *component, const ParameterEntry *entry, const unsigned char *from)
{
    int chosen;

    memcpy(&chosen, from, sizeof chosen);
    if (chosen < 0 || chosen >= entry->size)
        return refuse(component, "parameter %s must be one of the enumeration, got %d", entry->name, chosen);
    component->string[entry->place] = (char *)entry->choices[chosen]; /* only read from */
    return 0;
}

int parameter_values(Component *component, const FlexsatParameters *parameters)
{
    const ParameterEntry *entry;
    int value;

    component->string[PORT_DESIGN] = (char *)design_name;
    component->boolean[PORT_AS_PUBLISHED] = 0;
    for (entry = parameter_table; entry < parameter_table + parameter_count; entry++) {
        const unsigned char *from = (const unsigned char *)parameters + entry->offset;
        switch (entry->kind) {
        case PARAMETER_REAL:
            if (read_reals(component, entry, from))
                return 1;
            break;
        case PARAMETER_CHOICE:
            if (read_choice(component, entry, from))
                return 1;
            break;
        default:
            memcpy(&value, from, sizeof value);
            component->boolean[entry->place] = value != 0;
        }
    }
    return 0;
}
