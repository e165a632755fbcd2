/* The values of ports: where they start, which may be set, and which outputs are no numbers. */
#include "instance.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void set_start_values(Component *component)
{
    const Port *port;
    int k;

    for (port = ports; port < ports + port_table.ports; port++)
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
    int k;

    for (k = 0; k < (int)kind; k++)
        place += port_table.counts[k];
    return &ports[port_of_reference[place]];
}

const char *variable_name(const Port *port, int place, char name[REASON_SIZE])
{
    if (port->flags & ARRAY)
        snprintf(name, REASON_SIZE, port_table.element, port->name, place - port->first + 1);
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

int output_not_finite(const Component *component, int count)
{
    const double *outputs = component->real + port_table.first_real_output;
    double sums[8] = {0.0}, sum = 0.0; /* so many run at once, as none waits for the others */
    int k, i;

    for (k = 0; k + 7 < count; k += 8)
        for (i = 0; i < 8; i++)
            sums[i] += outputs[k + i];
    for (i = 0; i < 8; i++)
        sum += sums[i];
    for (; k < count; k++)
        sum += outputs[k];
    if (sum - sum == 0.0) /* it is not finite if one of them is not */
        return -1;
    for (k = 0; k < count; k++)
        if (!(fabs(outputs[k]) <= DBL_MAX))
            return port_table.first_real_output + k;
    return -1; /* only their sum is not */
}

void poison_outputs(Component *component)
{
    int k;

    for (k = 0; k < port_table.real_outputs; k++)
        component->real[port_table.first_real_output + k] = nan("");
}
