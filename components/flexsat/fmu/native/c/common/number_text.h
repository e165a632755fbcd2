/* Numbers in messages, as Python writes them. */
#ifndef FLEXSAT_NUMBER_TEXT_H
#define FLEXSAT_NUMBER_TEXT_H

#define NUMBER_SIZE 32 /* bytes of a number as text */

/* Write the shortest text that reads as the same number, whatever the host's locale; returns `text`. */
const char *number_text(double value, char text[NUMBER_SIZE]);

#endif
