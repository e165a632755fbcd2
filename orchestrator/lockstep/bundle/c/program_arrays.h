/* Read from the program what arrays the components of FMI 3.0 have. */
#ifndef BUNDLE_PROGRAM_ARRAYS_H
#define BUNDLE_PROGRAM_ARRAYS_H

#include "reader.h"

void read_arrays(reader_t *in, component_t *component);

/* Read the values of a type; NULL if the file is bad. */
void *read_values(reader_t *in, int type, uint32_t count);

/* Check that references of a component of FMI 3.0 are those of elements, which can be set if they are to be. */
void read_known(reader_t *in, const component_t *component, uint32_t type, const uint32_t *references, uint32_t count,
                int set);

#endif
