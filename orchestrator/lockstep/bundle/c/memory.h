/* Memory that lives as long as a bundle. */
#ifndef BUNDLE_MEMORY_H
#define BUNDLE_MEMORY_H

#include "bundle.h"

void *keep(bundle_t *bundle, size_t count, size_t size); /* zeroed; NULL if there is none */
void free_kept(bundle_t *bundle);
char *copy_text(const char *text); /* for free() */

/* Return memory of at least so many bytes, the same as before if it is large enough; NULL if there is none. */
void *grown(room_t *room, size_t size);

#endif
