#include "messages.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "interface.h"

enum { USUAL = 600 }; /* bytes of a message; a function's variables stay below a page, which Windows would probe */

static const char *const status_names[] = {"OK", "Warning", "Discard", "Error", "Fatal", "Pending"};

/* Return the length of a reference, which means a variable of the component, at the beginning of a text: #r1#, or #1#
in FMI 3.0; there two # are one. */
static size_t reference(const char *text, int third)
{
    size_t length = third ? 1 : 2;

    if (text[0] != '#' || text[1] == '\0' || (!third && strchr("ribs", text[1]) == NULL))
        return 0;
    if (third && text[1] == '#')
        return 2;
    while (text[length] >= '0' && text[length] <= '9')
        length++;
    return length > (third ? 1 : 2) && text[length] == '#' ? length + 1 : 0;
}

static const char *type_of(char letter)
{
    return letter >= '0' && letter <= '9' ? "variable " : letter == 'r' ? "Real " : letter == 'i' ? "Integer " : letter == 'b' ? "Boolean " : "String ";
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
static void pass_on(const bundle_t *bundle, fmi2Status status, const char *category, const component_t *component,
                    const char *text, int third)
{
    const char *name = component == NULL ? NULL : component->name;
    size_t prefix = name == NULL ? 0 : strlen(name), room = 4 * (strlen(text) + prefix) + 16, length;
    char usual[2 * USUAL], *passed = room > sizeof usual ? malloc(room) : usual, *end = passed;

    if (bundle->host.logger != NULL && passed != NULL) {
        if (name != NULL) {
            end = append(end, name, prefix);
            end = append(end, ": ", 2);
        }
        while (*text != '\0') {
            length = component == NULL ? 0 : reference(text, third);
            if (length == 0)
                end = append(end, text++, 1);
            else if (length == 2) {
                end = append(end, text, 1);
                text += length;
            } else {
                const size_t number = third ? 1 : 2; /* where it begins */
                end = append(end, type_of(text[1]), strlen(type_of(text[1])));
                end = append(end, text + number, length - number - 1);
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
    pass_on(bundle, fmi2Error, "logStatusError", NULL, text, 0);
    return fmi2Error;
}

/* Write the name of a function as the version of a component spells it; it is given as in FMI 2.0, without prefix. */
static void name_call(const component_t *component, const char *call, char *name, size_t size)
{
    const int third = (component->flags & VERSION_3) != 0;
    char *state;

    snprintf(name, size, "fmi%c%s", third ? '3' : '2', call);
    state = third ? strstr(name, "FMUstate") : NULL;
    if (state != NULL)
        state[3] = 'S';
    state = third ? strstr(name, "DeSerialize") : NULL;
    if (state != NULL)
        state[2] = 's';
}

fmi2Status judge(component_t *component, const char *call, fmi2Status status)
{
    bundle_t *bundle = component->bundle;
    char text[USUAL], name[48];
    unsigned int number = (unsigned int)status;

    if (number <= fmi2Warning)
        return status;
    name_call(component, call, name, sizeof name);
    if (number > fmi2Pending)
        snprintf(text, sizeof text, "%s returned the unknown status %d at %.9g s", name, (int)status,
                 time_now(bundle));
    else
        snprintf(text, sizeof text, "%s returned fmi%c%s at %.9g s", name, name[3], status_names[number],
                 time_now(bundle));
    if (number > fmi2Fatal)
        status = fmi2Error;
    pass_on(bundle, status, status == fmi2Discard ? "logStatusDiscard" : "logStatusError", component, text, 0);
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
        pass_on(component->bundle, status, category, component, text, 0);
    if (text != usual)
        free(text);
}

void component_message3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                        fmi3String message)
{
    const component_t *component = environment;

    if (component != NULL && message != NULL)
        pass_on(component->bundle, (fmi2Status)status, category, component, message, 1);
}
