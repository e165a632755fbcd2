/* UTF-8: what strings of FMI are, and what a host or a cut may have made of them. */
#include "instance.h"

/* Return the length of the UTF-8 sequence at `text`, or 0 if there is none: no overlong form, no surrogate. */
static int sequence(const char *text)
{
    static const unsigned long least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char *bytes = (const unsigned char *)text;
    unsigned long letter;
    int length, k;

    if (bytes[0] < 0x80)
        return 1;
    if (bytes[0] < 0xc2 || bytes[0] > 0xf4)
        return 0;
    length = bytes[0] >= 0xf0 ? 4 : bytes[0] >= 0xe0 ? 3 : 2;
    letter = bytes[0] & (0x7fu >> length);
    for (k = 1; k < length; k++) {
        if ((bytes[k] & 0xc0) != 0x80) /* the zero at the end too */
            return 0;
        letter = letter << 6 | (bytes[k] & 0x3fu);
    }
    if (letter < least[length] || letter > 0x10ffff || (letter >= 0xd800 && letter <= 0xdfff))
        return 0;
    return length;
}

int is_utf8(const char *text)
{
    while (*text) {
        const int length = sequence(text);
        if (length == 0)
            return 0;
        text += length;
    }
    return 1;
}

void make_line(char *text)
{
    while (*text) {
        const int length = sequence(text);
        if (length == 0 || (length == 1 && ((unsigned char)*text < 0x20 || *text == 0x7f)))
            *text = '?';
        text += length ? length : 1;
    }
}
