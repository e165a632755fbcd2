/* The folder of the resources: FMI 2.0 names it by a file: URI, FMI 3.0 by its path. All results are for free(). */
#ifndef BUNDLE_RESOURCE_FOLDER_H
#define BUNDLE_RESOURCE_FOLDER_H

/* Return the path of a file: URI, without a slash at its end; NULL if it is none. */
char *folder_of_uri(const char *uri);

/* Return a path without a separator at its end, and the URI of such a path; NULL if there is no memory. */
char *folder_of_path(const char *path);
char *uri_of_folder(const char *folder);

#endif
