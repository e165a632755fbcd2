/* What differs between operating systems: loading a library, opening a file, and where an FMU has its library. */
#ifndef BUNDLE_LIBRARY_H
#define BUNDLE_LIBRARY_H

#include <stddef.h>
#include <stdio.h>

#define LIBRARY_PLACES 2
extern const char *const library_folders[LIBRARY_PLACES]; /* below binaries/, the first that has it counts */
extern const char library_suffix[];

/* Paths are UTF-8. */
void *library_open(const char *path); /* NULL: library_error says why */
void *library_symbol(void *library, const char *name);
void library_close(void *library);
void library_error(char *text, size_t size);
FILE *open_to_read(const char *path);

#endif
