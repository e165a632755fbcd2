/* The folder that fmuResourceLocation names. */
#ifndef BUNDLE_RESOURCE_FOLDER_H
#define BUNDLE_RESOURCE_FOLDER_H

/* Return the path of a file: URI, without a slash at its end, for free(); NULL if it is none. */
char *folder_of_uri(const char *uri);

#endif
