#include "component.h"

#include <stdarg.h>
#include <stdio.h>

int refuse(Component *component, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(component->message, sizeof component->message, format, arguments);
    va_end(arguments);
    return 1;
}
