/* Matrices for products that are made at every step: dense ones in panels of eight rows, and those of few elements. */
#ifndef FLEXSAT_PANELS_H
#define FLEXSAT_PANELS_H

#include "memory.h"
#include "real.h"

enum { PANEL = 8 }; /* rows whose sums run at once */

struct Panels;

/* y (rows) += a x (columns) */
typedef void PanelProduct(const struct Panels *panels, const Real *x, Real *y);

/* The same with two vectors at once, which reads the matrix once. */
typedef void PanelProducts(const struct Panels *panels, const Real *x, const Real *other_x, Real *y, Real *other_y);

/* The rows of a matrix that are not 0, eight at a time; of its columns a panel has runs, without zeros between them. */
typedef struct Panels {
    int rows, columns; /* of the matrix */
    int count;
    int *row;    /* (8 count) of the matrix; those that fill the last panel up are its first row, times 0 */
    int *first;  /* (count + 1) run of columns */
    int *from;   /* (runs) its first column */
    int *width;  /* (runs) and how many it has */
    Real *value; /* run after run of a panel, column after column, eight values each */
    PanelProduct *product; /* those for this processor */
    PanelProducts *products;
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
