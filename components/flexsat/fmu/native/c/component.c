#include "component.h"

#include <stdarg.h>
#include <stdio.h>

int refuse(Component *component, const char *format, ...)
{
    va_list values;

    va_start(values, format);
    vsnprintf(component->message, MESSAGE_SIZE, format, values);
    va_end(values);
    return 1;
}
