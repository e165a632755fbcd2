#include "messages.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "interface.h"

enum { USUAL = 600 }; /* bytes of a message; a function's variables stay below a page, which Windows would probe */

static const char *const status_names[] = {"fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal",
                                           "fmi2Pending"};

/* Return the length of a reference such as #r1#, which means a variable of the component, at the beginning of a text. */
static size_t reference(const char *text)
{
    size_t length = 2;

    if (text[0] != '#' || text[1] == '\0' || strchr("ribs", text[1]) == NULL)
        return 0;
    while (text[length] >= '0' && text[length] <= '9')
        length++;
    return length > 2 && text[length] == '#' ? length + 1 : 0;
}

static const char *type_of(char letter)
{
    return letter == 'r' ? "Real " : letter == 'i' ? "Integer " : letter == 'b' ? "Boolean " : "String ";
}

static char *append(char *to, const char *text, size_t length)
{
    for (size_t k = 0; k < length; k++) {
        *to++ = text[k];
        if (text[k] == host_mark)
            *to++ = host_mark;
    }
    return to;
}

/* Pass on a text as it is, but for references, which a host would take for variables of the bundle. */
static void pass_on(const bundle_t *bundle, fmi2Status status, const char *category, const char *name,
                    const char *text)
{
    size_t prefix = name == NULL ? 0 : strlen(name), room = 4 * (strlen(text) + prefix) + 8, length;
    char usual[2 * USUAL], *passed = room > sizeof usual ? malloc(room) : usual, *end = passed;

    if (bundle->host.logger != NULL && passed != NULL) {
        if (name != NULL) {
            end = append(end, name, prefix);
            end = append(end, ": ", 2);
        }
        while (*text != '\0') {
            length = reference(text);
            if (length == 0)
                end = append(end, text++, 1);
            else {
                end = append(end, type_of(text[1]), strlen(type_of(text[1])));
                end = append(end, text + 2, length - 3);
                text += length;
            }
        }
        *end = '\0';
        host_message(bundle, status, category, passed);
    }
    if (passed != usual)
        free(passed);
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
