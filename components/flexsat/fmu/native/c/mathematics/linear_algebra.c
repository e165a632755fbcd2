#include "linear_algebra.h"

#include <math.h>
#include <string.h>

void times_vector(int m, int n, const double *a, const double *x, double *y)
{
    memset(y, 0, (size_t)m * sizeof(double));
    add_times_vector(m, n, a, x, y);
}

/* Four sums run at once, so that a processor need not wait for each; their order is fixed. */
void add_times_vector(int m, int n, const double *a, const double *x, double *y)
{
    int i, j;

    for (i = 0; i < m; i++, a += n) {
        double first = 0.0, second = 0.0, third = 0.0, fourth = 0.0;
        for (j = 0; j + 3 < n; j += 4) {
            first += a[j] * x[j];
            second += a[j + 1] * x[j + 1];
            third += a[j + 2] * x[j + 2];
            fourth += a[j + 3] * x[j + 3];
        }
        for (; j < n; j++)
            first += a[j] * x[j];
        y[i] += (first + second) + (third + fourth);
    }
}

void times_matrix(int m, int k, int n, const double *a, const double *b, double *c)
{
    memset(c, 0, (size_t)m * (size_t)n * sizeof(double));
    add_times_matrix(m, k, n, a, b, c);
}

void add_times_matrix(int m, int k, int n, const double *a, const double *b, double *c)
{
    int i, j, l;

    for (i = 0; i < m; i++, c += n)
        for (l = 0; l < k; l++) {
            const double factor = a[(size_t)i * (size_t)k + (size_t)l];
            const double *row = b + (size_t)l * (size_t)n;
            if (factor == 0.0)
                continue;
            for (j = 0; j < n; j++)
                c[j] += factor * row[j];
        }
}

void transpose(int m, int n, const double *a, double *b)
{
    int i, j;

    for (i = 0; i < m; i++)
        for (j = 0; j < n; j++)
            b[(size_t)j * (size_t)m + (size_t)i] = a[(size_t)i * (size_t)n + (size_t)j];
}

void identity(int n, double *a)
{
    int i;

    memset(a, 0, (size_t)n * (size_t)n * sizeof(double));
    for (i = 0; i < n; i++)
        a[(size_t)i * (size_t)n + (size_t)i] = 1.0;
}

static void swap_rows(int n, double *first, double *second)
{
    int j;

    for (j = 0; j < n; j++) {
        const double kept = first[j];
        first[j] = second[j];
        second[j] = kept;
    }
}

int solve(int n, int m, double *a, double *b)
{
    const size_t width = (size_t)n, columns = (size_t)m;
    int i, j, k;

    for (k = 0; k < n; k++) {
        int pivot = k;
        for (i = k + 1; i < n; i++)
            if (fabs(a[(size_t)i * width + (size_t)k]) > fabs(a[(size_t)pivot * width + (size_t)k]))
                pivot = i;
        if (!(fabs(a[(size_t)pivot * width + (size_t)k]) > 0.0))
            return 1;
        if (pivot != k) {
            swap_rows(n, a + (size_t)k * width, a + (size_t)pivot * width);
            swap_rows(m, b + (size_t)k * columns, b + (size_t)pivot * columns);
        }
        for (i = k + 1; i < n; i++) {
            double *row = a + (size_t)i * width;
            const double *upper = a + (size_t)k * width;
            const double factor = row[k] / upper[k];
            if (factor == 0.0)
                continue;
            for (j = k + 1; j < n; j++)
                row[j] -= factor * upper[j];
            for (j = 0; j < m; j++)
                b[(size_t)i * columns + (size_t)j] -= factor * b[(size_t)k * columns + (size_t)j];
        }
    }
    for (k = n - 1; k >= 0; k--) {
        const double *row = a + (size_t)k * width;
        double *right = b + (size_t)k * columns;
        for (i = k + 1; i < n; i++)
            for (j = 0; j < m; j++)
                right[j] -= row[i] * b[(size_t)i * columns + (size_t)j];
        for (j = 0; j < m; j++)
            right[j] /= row[k];
    }
    return 0;
}

int invert(int n, double *a, double *inverse)
{
    identity(n, inverse);
    return solve(n, n, a, inverse);
}

int cholesky(int n, double *a)
{
    const size_t width = (size_t)n;
    int i, j, k;

    for (j = 0; j < n; j++) {
        double *row = a + (size_t)j * width;
        double diagonal = row[j];
        for (k = 0; k < j; k++)
            diagonal -= row[k] * row[k];
        if (!(diagonal > 0.0))
            return 1;
        row[j] = sqrt(diagonal);
        for (i = j + 1; i < n; i++) {
            double *below = a + (size_t)i * width;
            double sum = below[j];
            for (k = 0; k < j; k++)
                sum -= below[k] * row[k];
            below[j] = sum / row[j];
        }
    }
    return 0;
}
