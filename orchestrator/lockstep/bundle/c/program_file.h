/* Read resources/program.bin, which lockstep/bundle/program_file.py writes. */
#ifndef BUNDLE_PROGRAM_FILE_H
#define BUNDLE_PROGRAM_FILE_H

#include "bundle.h"

/* Fill a bundle whose `resources` are known; return NULL, or what is wrong. */
const char *read_program(bundle_t *bundle);

#endif
