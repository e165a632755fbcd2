/* What is logged: one line for each refused call. */
#include "instance.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void pass_on(const Host *host, const char *name, Status status, char *text)
{
    make_line(text); /* it may quote what a host gave, and be cut inside a letter */
    send_to_host(host, name, status, text);
}

void log_to_host(const Host *host, const char *name, Status status, const char *format, ...)
{
    char text[REASON_SIZE];
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pass_on(host, name, status, text);
}

Status refuse_call(Instance *instance, const char *call, const char *format, ...)
{
    char text[REASON_SIZE];
    va_list arguments;
    int written;

    written = snprintf(text, sizeof text, "%s: ", call);
    if (written > 0 && (size_t)written < sizeof text) {
        va_start(arguments, format);
        vsnprintf(text + written, sizeof text - (size_t)written, format, arguments);
        va_end(arguments);
    }
    if (instance->failure[0] == '\0') {
        strcpy(instance->failure, text);
        poison_outputs(&instance->component); /* so that they are not mistaken for results */
    }
    instance->phase = FAILED;
    pass_on(&instance->host, instance->name, CALL_ERROR, text);
    return CALL_ERROR;
}

Status refuse_for_model(Instance *instance, const char *call)
{
    const char *message = instance->component.message;

    instance->started = 0;
    return refuse_call(instance, call, "%s", message[0] != '\0' ? message : "the model gives no reason");
}
