#include "messages.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { USUAL = 1000 }; /* bytes of a message */

static const char *const status_names[] = {"fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal",
                                           "fmi2Pending"};

/* Pass on a text as it is: a host takes it for a format, and #r1# for a variable of the bundle. */
static void pass_on(const bundle_t *bundle, fmi2Status status, const char *category, const char *name,
                    const char *text)
{
    size_t length = strlen(text), prefix = name == NULL ? 0 : strlen(name) + 2;
    char usual[4 * USUAL], *escaped = usual, *end;

    if (bundle->host.logger == NULL)
        return;
    if (2 * (length + prefix) >= sizeof usual)
        escaped = malloc(2 * (length + prefix) + 1);
    if (escaped == NULL)
        return;
    end = escaped;
    for (size_t k = 0; k < prefix + length; k++) {
        char letter = k + 2 < prefix ? name[k] : k + 2 == prefix ? ':' : k < prefix ? ' ' : text[k - prefix];
        *end++ = letter;
        if (letter == '%' || letter == '#')
            *end++ = letter;
    }
    *end = '\0';
    bundle->host.logger(bundle->host.componentEnvironment, bundle->name, status, category, escaped);
    if (escaped != usual)
        free(escaped);
}

fmi2Status refuse(const bundle_t *bundle, const char *format, ...)
{
    char text[USUAL];
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pass_on(bundle, fmi2Error, "logStatusError", NULL, text);
    return fmi2Error;
}

fmi2Status judge(component_t *component, const char *call, fmi2Status status)
{
    bundle_t *bundle = component->bundle;
    char text[USUAL];
    unsigned int number = (unsigned int)status;

    if (number <= fmi2Warning)
        return status;
    if (number > fmi2Pending)
        snprintf(text, sizeof text, "%s returned the unknown status %d at %.9g s", call, (int)status,
                 time_now(bundle));
    else
        snprintf(text, sizeof text, "%s returned %s at %.9g s", call, status_names[number],
                 time_now(bundle));
    if (number > fmi2Fatal)
        status = fmi2Error;
    pass_on(bundle, status, status == fmi2Discard ? "logStatusDiscard" : "logStatusError", component->name, text);
    if (component->worst < status)
        component->worst = status;
    if (status == fmi2Fatal)
        bundle->life = FATAL;
    return status;
}

void component_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                       fmi2String category, fmi2String message, ...)
{
    const component_t *component = environment;
    char usual[USUAL], *text = usual;
    va_list arguments, again;
    int length;

    (void)instance;
    if (component == NULL || message == NULL)
        return;
    va_start(arguments, message);
    va_copy(again, arguments);
    length = vsnprintf(usual, sizeof usual, message, arguments);
    va_end(arguments);
    if (length >= (int)sizeof usual) {
        text = malloc((size_t)length + 1);
        if (text == NULL)
            text = usual;
        else
            vsnprintf(text, (size_t)length + 1, message, again);
    }
    va_end(again);
    if (length >= 0)
        pass_on(component->bundle, status, category, component->name, text);
    if (text != usual)
        free(text);
}
