/* The values of ports: where they start, which may be set, and which outputs are no numbers. */
#include "instance.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const int first_reference[KINDS + 1] = {0, REAL_COUNT, REAL_COUNT + INTEGER_COUNT,
                                               REAL_COUNT + INTEGER_COUNT + BOOLEAN_COUNT, VARIABLE_COUNT};

void set_start_values(Component *component)
{
    const Port *port;
    int k;

    for (port = ports; port < ports + PORT_COUNT; port++)
        for (k = 0; k < port->size; k++) {
            const int place = port->first + k;
            const double start = port->starts != NULL ? port->starts[k] : port->start;
            switch (port->kind) {
            case REAL: component->real[place] = start; break;
            case INTEGER: component->integer[place] = (int)start; break;
            case BOOLEAN: component->boolean[place] = start != 0.0; break;
            default: strcpy(component->string[place], port->text); break;
            }
        }
}

const Port *port_at(Kind kind, int place)
{
    return &ports[port_of_reference[first_reference[kind] + place]];
}

const char *variable_name(const Port *port, int place, char name[REASON_SIZE])
{
    if (port->flags & ARRAY)
        snprintf(name, REASON_SIZE, ELEMENT_NAME, port->name, place - port->first + 1);
    else
        snprintf(name, REASON_SIZE, "%s", port->name);
    return name;
}

int acceptable(const Port *port, double value, char why[REASON_SIZE])
{
    char text[NUMBER_SIZE];

    if (value >= port->least && value <= port->greatest)
        return 1;
    if (port->kind == INTEGER)
        snprintf(text, sizeof text, "%d", (int)value);
    else
        number_text(value, text);
    if (!(fabs(value) <= DBL_MAX))
        snprintf(why, REASON_SIZE, "must be finite, got %s", text);
    else if (value < port->least)
        snprintf(why, REASON_SIZE, "must be >= %s, got %s", port->lower, text);
    else
        snprintf(why, REASON_SIZE, "must be <= %s, got %s", port->upper, text);
    return 0;
}

int output_not_finite(const Component *component)
{
    const double *outputs = component->real + FIRST_REAL_OUTPUT;
    double sum = 0.0;
    int k;

    for (k = 0; k < REAL_OUTPUTS; k++)
        sum += 0.0 * outputs[k]; /* not-a-number times zero, and infinity times zero, are not-a-number */
    if (sum == 0.0)
        return -1;
    for (k = 0; k < REAL_OUTPUTS; k++)
        if (!(fabs(outputs[k]) <= DBL_MAX))
            break;
    return FIRST_REAL_OUTPUT + k;
}

void poison_outputs(Component *component)
{
    int k;

    for (k = 0; k < REAL_OUTPUTS; k++)
        component->real[FIRST_REAL_OUTPUT + k] = nan("");
}
