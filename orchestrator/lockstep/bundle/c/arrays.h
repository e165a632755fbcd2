/* Values of components of FMI 3.0: each call transfers whole arrays, and a bundle knows their elements one by one. */
#ifndef BUNDLE_ARRAYS_H
#define BUNDLE_ARRAYS_H

#include "bundle.h"

extern const size_t array_sizes[ALL_TYPES]; /* of an element */

/* Give the arrays that can be set their start values, as after instantiation. Return 0 if there is no memory. */
int start_arrays(component_t *component);
void free_arrays(component_t *component);

/* Set and get elements by their references, as fmi2Set and fmi2Get would. */
fmi2Status set_elements(component_t *component, int type, const uint32_t *references, size_t count, const void *values);
fmi2Status get_elements(component_t *component, int type, const uint32_t *references, size_t count, void *values);

/* Touch the arrays of elements, and find the runs of neighbours among them: the first array from `array` on, and the
one after the last, until 0 is returned. They are no longer touched afterwards. */
void touch_arrays(const component_t *component, int type, const uint32_t *references, size_t count);
int next_run(const arrays_t *arrays, uint32_t *array, uint32_t *end);

#endif
