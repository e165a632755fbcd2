#include "panels.h"

int panels_take(Memory *memory, int rows, int columns, Panels *panels)
{
    const size_t most = ((size_t)rows + PANEL - 1) / PANEL;

    panels->rows = rows;
    panels->columns = columns;
    panels->count = 0;
    panels->row = memory_take(memory, most * PANEL, sizeof(int));
    panels->from = memory_take(memory, most, sizeof(int));
    panels->to = memory_take(memory, most, sizeof(int));
    panels->place = memory_take(memory, most, sizeof(size_t));
    panels->value = memory_doubles(memory, most * PANEL * (size_t)columns);
    return memory->failed;
}

static int is_zero(int n, const double *row)
{
    int j;

    for (j = 0; j < n; j++)
        if (row[j] != 0.0)
            return 0;
    return 1;
}

void panels_fill(const double *a, Panels *panels)
{
    const size_t columns = (size_t)panels->columns;
    size_t place = 0;
    int kept = 0, i, j, k, panel;

    for (i = 0; i < panels->rows; i++)
        if (!is_zero(panels->columns, a + (size_t)i * columns))
            panels->row[kept++] = i;
    panels->count = (kept + PANEL - 1) / PANEL;
    for (panel = 0; panel < panels->count; panel++) {
        int *row = panels->row + PANEL * panel, filled = kept - PANEL * panel;
        int from = panels->columns, to = 0;
        if (filled > PANEL)
            filled = PANEL;
        for (k = filled; k < PANEL; k++)
            row[k] = row[0];
        for (k = 0; k < filled; k++)
            for (j = 0; j < panels->columns; j++)
                if (a[(size_t)row[k] * columns + (size_t)j] != 0.0) {
                    from = j < from ? j : from;
                    to = j >= to ? j + 1 : to;
                }
        panels->from[panel] = from;
        panels->to[panel] = to;
        panels->place[panel] = place;
        for (j = from; j < to; j++)
            for (k = 0; k < PANEL; k++)
                panels->value[place++] = k < filled ? a[(size_t)row[k] * columns + (size_t)j] : 0.0;
    }
}

void panels_add_times(const Panels *panels, const double *x, double *y)
{
    int panel, j;

    for (panel = 0; panel < panels->count; panel++) {
        const double *value = panels->value + panels->place[panel];
        const int *row = panels->row + PANEL * panel, to = panels->to[panel];
        double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0, s4 = 0.0, s5 = 0.0, s6 = 0.0, s7 = 0.0;
        for (j = panels->from[panel]; j < to; j++, value += PANEL) {
            const double factor = x[j];
            s0 += value[0] * factor;
            s1 += value[1] * factor;
            s2 += value[2] * factor;
            s3 += value[3] * factor;
            s4 += value[4] * factor;
            s5 += value[5] * factor;
            s6 += value[6] * factor;
            s7 += value[7] * factor;
        }
        y[row[0]] += s0;
        y[row[1]] += s1;
        y[row[2]] += s2;
        y[row[3]] += s3;
        y[row[4]] += s4;
        y[row[5]] += s5;
        y[row[6]] += s6;
        y[row[7]] += s7;
    }
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
