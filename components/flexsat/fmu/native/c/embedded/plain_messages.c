/* refuse of component.h and number_text of number_text.h without stdio: a target need not have it. */
#include "component.h"
#include "number_text.h"

#include <math.h>
#include <stdarg.h>

enum { DIGITS = 6 };

/* Append a letter if there is room for it and the zero at the end. */
static char *letter(char *end, const char *last, char value)
{
    if (end < last)
        *end++ = value;
    return end;
}

static char *word(char *end, const char *last, const char *text)
{
    while (*text != '\0')
        end = letter(end, last, *text++);
    return end;
}

/* A whole number from 0 below 1e9, with zeros before it up to a width. */
static char *whole(char *end, const char *last, long value, int width)
{
    char digits[12];
    int count = 0;

    do {
        digits[count++] = (char)('0' + (int)(value % 10));
        value /= 10;
    } while (value > 0 && count < 10);
    while (count < width)
        digits[count++] = '0';
    while (count > 0)
        end = letter(end, last, digits[--count]);
    return end;
}

/* A number of six significant digits: 0.0125, 3.5e-07. */
static char *number(char *end, const char *last, double value)
{
    int exponent = 0, decimals = DIGITS - 1;
    long digits, unit = 1; /* one, in units of the last digit */

    if (!(fabs(value) <= 1.7976931348623157e308))
        return word(end, last, value != value ? "nan" : value < 0.0 ? "-inf" : "inf");
    if (value < 0.0)
        end = letter(end, last, '-');
    value = fabs(value);
    if (value > 0.0)
        exponent = (int)floor(log10(value));
    if (exponent >= -4 && exponent <= 8) { /* written as it is */
        decimals = DIGITS - 1 - exponent;
        decimals = decimals > DIGITS ? DIGITS : decimals < 0 ? 0 : decimals;
        exponent = 0;
    } else {
        value = value / pow(10.0, exponent);
    }
    for (; decimals > 0; decimals--)
        unit *= 10;
    digits = (long)floor((value - floor(value)) * (double)unit + 0.5);
    value = floor(value) + (digits >= unit ? 1.0 : 0.0);
    digits = digits >= unit ? 0 : digits;
    end = whole(end, last, (long)value, 1);
    if (digits > 0) {
        int width = 0;
        long left;
        while (digits % 10 == 0) {
            digits /= 10;
            unit /= 10;
        }
        for (left = unit; left > 1; left /= 10)
            width++;
        end = whole(letter(end, last, '.'), last, digits, width);
    }
    if (exponent != 0) {
        end = word(end, last, exponent < 0 ? "e-" : "e+");
        end = whole(end, last, exponent < 0 ? -exponent : exponent, 2);
    }
    return end;
}

const char *number_text(double value, char text[NUMBER_SIZE])
{
    *number(text, text + NUMBER_SIZE - 1, value) = '\0';
    return text;
}

/* Knows %s, %d and numbers, whose digits are six at most whatever the format has. */
int refuse(Component *component, const char *format, ...)
{
    char *end = component->message;
    const char *last = end + sizeof component->message - 1;
    va_list arguments;

    va_start(arguments, format);
    for (; *format != '\0'; format++) {
        if (*format != '%') {
            end = letter(end, last, *format);
            continue;
        }
        for (format++; *format == '.' || (*format >= '0' && *format <= '9'); format++)
            continue;
        if (*format == 's') {
            end = word(end, last, va_arg(arguments, const char *));
        } else if (*format == 'd') {
            const int value = va_arg(arguments, int);
            end = whole(value < 0 ? letter(end, last, '-') : end, last, value < 0 ? -(long)value : value, 1);
        } else {
            end = number(end, last, va_arg(arguments, double));
        }
    }
    va_end(arguments);
    *end = '\0';
    return 1;
}
