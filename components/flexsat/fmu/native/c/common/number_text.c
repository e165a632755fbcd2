#include "number_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 17 }; /* with which every double can be written */

/* Write the digits of a positive number and return its decimal exponent: digits[0].digits[1]... * 10^exponent */
static int shortest_digits(double value, char digits[DIGITS + 1])
{
    char text[NUMBER_SIZE];
    const char *letter;
    int count, length = 0;

    for (count = 0; count < DIGITS; count++) {
        snprintf(text, sizeof text, "%.*e", count, value);
        if (strtod(text, NULL) == value)
            break;
    }
    for (letter = text; *letter != 'e' && *letter != '\0'; letter++) /* the decimal point depends on the locale */
        if (*letter >= '0' && *letter <= '9' && length < DIGITS)
            digits[length++] = *letter;
    digits[length] = '\0';
    return *letter == 'e' ? atoi(letter + 1) : 0;
}

const char *number_text(double value, char text[NUMBER_SIZE])
{
    char digits[DIGITS + 1], *end = text;
    int exponent, length, k;

    if (value != value)
        return strcpy(text, "nan");
    if (value < 0.0 || (value == 0.0 && copysign(1.0, value) < 0.0))
        *end++ = '-';
    value = fabs(value);
    if (value > 1.7976931348623157e308) {
        strcpy(end, "inf");
        return text;
    }
    exponent = value == 0.0 ? 0 : shortest_digits(value, digits);
    if (value == 0.0)
        strcpy(digits, "0");
    length = (int)strlen(digits);
    if (exponent < -4 || exponent >= 16) {
        *end++ = digits[0];
        if (length > 1)
            end += sprintf(end, ".%s", digits + 1);
        sprintf(end, "e%c%02d", exponent < 0 ? '-' : '+', abs(exponent));
        return text;
    }
    if (exponent < 0) {
        end += sprintf(end, "0.");
        for (k = exponent + 1; k < 0; k++)
            *end++ = '0';
        strcpy(end, digits);
        return text;
    }
    for (k = 0; k <= exponent; k++)
        *end++ = k < length ? digits[k] : '0';
    sprintf(end, ".%s", length > exponent + 1 ? digits + exponent + 1 : "0");
    return text;
}
