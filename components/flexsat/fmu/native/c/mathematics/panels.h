/* Matrices for products that are made at every step: dense ones in panels of eight rows, and those of few elements. */
#ifndef FLEXSAT_PANELS_H
#define FLEXSAT_PANELS_H

#include "memory.h"
#include "real.h"

enum { PANEL = 8 }; /* rows whose sums run at once */

/* The rows of a matrix that are not 0, eight at a time; a panel lacks the columns before and behind its elements. */
typedef struct Panels {
    int rows, columns; /* of the matrix */
    int count;
    int *row;         /* (8 count) of the matrix; those that fill the last panel up are its first row, times 0 */
    int *from, *to;   /* (count) columns */
    size_t *place;    /* (count) of a panel's first value */
    Real *value;      /* column after column of a panel, eight values each */
    void (*product)(const struct Panels *panels, const Real *x, Real *y); /* for this processor */
} Panels;

/* Take memory for any matrix of this size; returns 0, or 1 without memory. */
int panels_take(Memory *memory, int rows, int columns, Panels *panels);

/* Arrange a (rows, columns). */
void panels_fill(const double *a, Panels *panels);

/* y (rows) += a x (columns) */
void panels_add_times(const Panels *panels, const Real *x, Real *y);

/* The same with sums of doubles, whatever Real is. */
void panels_add_times_exactly(const Panels *panels, const double *x, double *y);

/* The elements of a matrix that are not 0, row after row. */
typedef struct Sparse {
    int rows;
    int *first; /* (rows + 1) element of each row */
    int *column;
    double *value;
} Sparse;

/* Arrange a (rows, columns); returns 0, or 1 without memory. */
int sparse_of(Memory *memory, int rows, int columns, const double *a, Sparse *sparse);

/* y (rows) = a x (columns) */
void sparse_times(const Sparse *sparse, const double *x, double *y);

#endif
