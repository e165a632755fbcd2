#include "panels.h"

#include <stdint.h>

#include "panel_products.h"

enum {
    LINE = 64, /* bytes of a cache line: a register full of values lies in one */
    GAP = 4    /* columns of zeros that end a run: less are quicker multiplied than left out */
};

int panels_take(Memory *memory, int rows, int columns, Panels *panels)
{
    const size_t most = ((size_t)rows + PANEL - 1) / PANEL, runs = most * ((size_t)columns / (GAP + 1) + 1);
    unsigned char *value;

    panels->rows = rows;
    panels->columns = columns;
    panels->count = 0;
    panels->row = memory_take(memory, most * PANEL, sizeof(int));
    panels->first = memory_take(memory, most + 1, sizeof(int));
    panels->from = memory_take(memory, runs, sizeof(int));
    panels->width = memory_take(memory, runs, sizeof(int));
    choose_products(panels);
    value = memory_take(memory, most * PANEL * (size_t)columns * sizeof(Real) + LINE, 1);
    if (memory->failed)
        return 1;
    panels->value = (Real *)(void *)(value + (LINE - (uintptr_t)value % LINE) % LINE);
    return 0;
}

static int is_zero(int n, const double *row)
{
    int j;

    for (j = 0; j < n; j++)
        if (row[j] != 0.0)
            return 0;
    return 1;
}

/* Whether a column of some rows is 0. */
static int is_zero_column(const double *a, size_t columns, int count, const int *row, int column)
{
    int k;

    for (k = 0; k < count; k++)
        if (a[(size_t)row[k] * columns + (size_t)column] != 0.0)
            return 0;
    return 1;
}

/* Divide the columns of a panel into runs, `last` of them before; returns how many there are after. */
static int find_runs(const double *a, int count, const int *row, int last, Panels *panels)
{
    const int first = last;
    int j;

    for (j = 0; j < panels->columns; j++) {
        if (is_zero_column(a, (size_t)panels->columns, count, row, j))
            continue;
        if (last == first || j - (panels->from[last - 1] + panels->width[last - 1]) >= GAP)
            panels->from[last++] = j;
        panels->width[last - 1] = j + 1 - panels->from[last - 1];
    }
    return last;
}

void panels_fill(const double *a, Panels *panels)
{
    const size_t columns = (size_t)panels->columns;
    Real *value = panels->value;
    int kept = 0, i, j, k, panel, run;

    for (i = 0; i < panels->rows; i++)
        if (!is_zero(panels->columns, a + (size_t)i * columns))
            panels->row[kept++] = i;
    panels->count = (kept + PANEL - 1) / PANEL;
    panels->first[0] = 0;
    for (panel = 0; panel < panels->count; panel++) {
        int *row = panels->row + PANEL * panel, filled = kept - PANEL * panel;
        if (filled > PANEL)
            filled = PANEL;
        for (k = filled; k < PANEL; k++)
            row[k] = row[0];
        panels->first[panel + 1] = find_runs(a, filled, row, panels->first[panel], panels);
        for (run = panels->first[panel]; run < panels->first[panel + 1]; run++)
            for (j = panels->from[run]; j < panels->from[run] + panels->width[run]; j++)
                for (k = 0; k < PANEL; k++)
                    *value++ = (Real)(k < filled ? a[(size_t)row[k] * columns + (size_t)j] : 0.0);
    }
}

void panels_add_times(const Panels *panels, const Real *x, Real *y) { panels->product(panels, x, y); }

void panels_add_times_exactly(const Panels *panels, const double *x, double *y)
{
#ifdef FLEXSAT_FLOATS
    const Real *value = panels->value;
    int panel, run, j, k;

    for (panel = 0; panel < panels->count; panel++) {
        const int *row = panels->row + PANEL * panel;
        double sums[PANEL] = {0.0};
        for (run = panels->first[panel]; run < panels->first[panel + 1]; run++)
            for (j = panels->from[run]; j < panels->from[run] + panels->width[run]; j++, value += PANEL)
                for (k = 0; k < PANEL; k++)
                    sums[k] += value[k] * x[j];
        for (k = 0; k < PANEL; k++)
            y[row[k]] += sums[k];
    }
#else
    panels_add_times(panels, x, y);
#endif
}

int sparse_of(Memory *memory, int rows, int columns, const double *a, Sparse *sparse)
{
    const size_t count = (size_t)rows * (size_t)columns;
    size_t kept = 0, e;
    int i, j;

    for (e = 0; e < count; e++)
        kept += a[e] != 0.0;
    sparse->rows = rows;
    sparse->first = memory_take(memory, (size_t)rows + 1, sizeof(int));
    sparse->column = memory_take(memory, kept, sizeof(int));
    sparse->value = memory_doubles(memory, kept);
    if (memory->failed)
        return 1;
    kept = 0;
    for (i = 0; i < rows; i++) {
        sparse->first[i] = (int)kept;
        for (j = 0; j < columns; j++, a++)
            if (*a != 0.0) {
                sparse->column[kept] = j;
                sparse->value[kept++] = *a;
            }
    }
    sparse->first[rows] = (int)kept;
    return 0;
}

void sparse_times(const Sparse *sparse, const double *x, double *y)
{
    int i, e;

    for (i = 0; i < sparse->rows; i++) {
        double sum = 0.0;
        for (e = sparse->first[i]; e < sparse->first[i + 1]; e++)
            sum += sparse->value[e] * x[sparse->column[e]];
        y[i] = sum;
    }
}
