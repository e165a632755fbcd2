/* What the standard says of an instance (FMI 2.0.4, section 4.2.4): its state, and the values that a host has set. */
#ifndef FUZZ_MODEL_H
#define FUZZ_MODEL_H

#include "host.h"

typedef enum { NEW = 1, INITIALISING, RUNNING, ENDED, BROKEN } State;
typedef enum { OK_ONLY, ERROR_ONLY, EITHER } Answer; /* EITHER: the component, or memory, decides */

typedef struct Model {
    State state;
    int set_up, ends;
    double present, stop; /* s */
    double length;        /* s, of the steps before, where all have to be equal; 0: none */
    double *real;
    int *integer, *boolean;
    char (*text)[TEXT];
} Model;

Model *make_model(void); /* of a new instance */
void free_model(Model *model);
void copy_model(const Model *from, Model *to);
void begin_model(Model *model); /* as after fmi2Reset */

Answer may_read(const Model *model, Kind kind, const fmi2ValueReference vr[], size_t n, const void *values);
Answer may_write(const Model *model, Kind kind, const fmi2ValueReference vr[], size_t n, const void *values);
void write_values(Model *model, Kind kind, const fmi2ValueReference vr[], size_t n, const void *values);
Answer may_step(const Model *model, double time, double step);
Answer may_differentiate(const Model *model, const fmi2ValueReference unknown[], size_t unknowns,
                         const fmi2ValueReference known[], size_t knowns, const double seed[], const void *found);

/* Compare an instance with what a host has set; in BROKEN real outputs have to be not-a-number. */
void compare(fmi2Component c, const Model *model);

#endif
