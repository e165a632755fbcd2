/* By reflections to Hessenberg form, then by Francis' steps with two shifts at once; see Golub and Van Loan, Matrix
Computations, 4th edition, sections 7.4 and 7.5. */
#include "real_schur.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "linear_algebra.h"

enum { MOST_STEPS = 60, UNUSUAL_SHIFT = 10 }; /* for each eigenvalue */

/* Find the reflection I - scale v v' that turns x (n) into a multiple of the first axis: v replaces x. */
static double reflection(int n, double *x, double *length)
{
    double largest = 0.0, square = 0.0;
    int i;

    for (i = 0; i < n; i++)
        if (fabs(x[i]) > largest)
            largest = fabs(x[i]);
    *length = 0.0;
    if (!(largest > 0.0))
        return 0.0;
    for (i = 0; i < n; i++) {
        x[i] /= largest;
        square += x[i] * x[i];
    }
    *length = -copysign(sqrt(square), x[0]);
    x[0] -= *length;
    square = -*length * x[0]; /* half of v'v */
    *length *= largest;
    return 1.0 / square;
}

/* Apply I - scale v v' from the left to rows of `width` columns, of which those from `from` on change. */
static void reflect_rows(int n, int width, int from, const double *v, double scale, double *rows, double *sums)
{
    int i, j;

    memset(sums, 0, (size_t)width * sizeof(double));
    for (i = 0; i < n; i++) {
        const double *row = rows + (size_t)i * (size_t)width;
        for (j = from; j < width; j++)
            sums[j] += v[i] * row[j];
    }
    for (i = 0; i < n; i++) {
        double *row = rows + (size_t)i * (size_t)width;
        const double factor = scale * v[i];
        for (j = from; j < width; j++)
            row[j] -= factor * sums[j];
    }
}

static void hessenberg(int n, double *a, double *turned, double *work)
{
    const size_t width = (size_t)n;
    double *v = work, *sums = work + n;
    int i, j, k;

    for (k = 0; k + 2 < n; k++) {
        const int count = n - k - 1;
        double *below = a + (size_t)(k + 1) * width, scale, length;
        for (i = 0; i < count; i++)
            v[i] = below[(size_t)i * width + (size_t)k];
        scale = reflection(count, v, &length);
        if (!(scale > 0.0))
            continue;
        below[k] = length;
        for (i = 1; i < count; i++)
            below[(size_t)i * width + (size_t)k] = 0.0;
        reflect_rows(count, n, k + 1, v, scale, below, sums);
        reflect_rows(count, n, 0, v, scale, turned + (size_t)(k + 1) * width, sums);
        for (i = 0; i < n; i++) { /* and from the right */
            double *row = a + (size_t)i * width + (size_t)(k + 1), sum = 0.0;
            for (j = 0; j < count; j++)
                sum += row[j] * v[j];
            sum *= scale;
            for (j = 0; j < count; j++)
                row[j] -= sum * v[j];
        }
    }
}

/* Apply the reflection of `count` (2 or 3) neighbours from `k` on to rows of T, columns of T, and rows of Q'. */
static void reflect(int n, int count, int k, int from, int to, const double *v, double scale, double *t, double *turned)
{
    const size_t width = (size_t)n;
    double *rows = t + (size_t)k * width, *columns = t + k, *basis = turned + (size_t)k * width;
    const double v0 = v[0], v1 = v[1], v2 = count == 3 ? v[2] : 0.0;
    const size_t third = count == 3 ? 2 : 1; /* with v2 = 0, a place that is there */
    int i;

    for (i = from; i < n; i++) {
        const double sum = scale * (v0 * rows[i] + v1 * rows[width + (size_t)i] + v2 * rows[third * width + (size_t)i]);
        rows[i] -= sum * v0;
        rows[width + (size_t)i] -= sum * v1;
        rows[third * width + (size_t)i] -= sum * v2;
    }
    for (i = 0; i <= to; i++) {
        double *row = columns + (size_t)i * width;
        const double sum = scale * (v0 * row[0] + v1 * row[1] + v2 * row[third]);
        row[0] -= sum * v0;
        row[1] -= sum * v1;
        row[third] -= sum * v2;
    }
    for (i = 0; i < n; i++) {
        const double sum =
            scale * (v0 * basis[i] + v1 * basis[width + (size_t)i] + v2 * basis[third * width + (size_t)i]);
        basis[i] -= sum * v0;
        basis[width + (size_t)i] -= sum * v1;
        basis[third * width + (size_t)i] -= sum * v2;
    }
}

/* One step of Francis on the rows from `low` to `high`, at least three. The shifts are the eigenvalues of a matrix of
two rows with these elements on its diagonal, and this product of the others. */
static void francis_step(int n, int low, int high, const double shift[2], double crossed, double *t, double *turned)
{
    const size_t width = (size_t)n;
    const double *top = t + (size_t)low * width + (size_t)low;
    double v[3], scale, length;
    int k;

    /* the first column of (T - shift)(T - other shift), over its subdiagonal element */
    v[0] = ((top[0] - shift[0]) * (top[0] - shift[1]) - crossed) / top[width] + top[1];
    v[1] = (top[0] - shift[0]) + (top[width + 1] - shift[1]);
    v[2] = top[2 * width + 1];
    for (k = low; k < high; k++) {
        const int count = k + 2 <= high ? 3 : 2;
        double *before = t + (size_t)k * width + (size_t)k - 1; /* of column k - 1 */
        int i;
        if (k > low)
            for (i = 0; i < count; i++)
                v[i] = before[(size_t)i * width];
        scale = reflection(count, v, &length);
        if (!(scale > 0.0))
            continue;
        reflect(n, count, k, k, k + 3 < high ? k + 3 : high, v, scale, t, turned);
        if (k > low) {
            before[0] = length;
            for (i = 1; i < count; i++)
                before[(size_t)i * width] = 0.0;
        }
    }
}

/* Make a block of two, at k, triangular if its eigenvalues are real. */
static void split(int n, int k, double *t, double *turned)
{
    double *block = t + (size_t)k * (size_t)n + (size_t)k, *below = block + n;
    const double half = 0.5 * (block[0] - below[1]), square = half * half + block[1] * below[0];
    double v[2], scale, length;

    if (square < 0.0)
        return;
    /* an eigenvector, along which the first axis is laid; of the two eigenvalues that without cancellation */
    v[0] = half + copysign(sqrt(square), half);
    v[1] = below[0];
    scale = reflection(2, v, &length);
    if (scale > 0.0)
        reflect(n, 2, k, k, k + 1, v, scale, t, turned);
    below[0] = 0.0;
}

/* The first row of the part that does not fall into smaller ones and ends at row `high`. */
static int first_row(int n, int high, double size, double *t)
{
    int low;

    for (low = high; low > 0; low--) {
        double *at = t + (size_t)low * (size_t)n + (size_t)low; /* the element left of it couples the parts */
        double around = fabs(at[0]) + fabs(at[-1 - n]);
        if (!(around > 0.0))
            around = size;
        if (fabs(at[-1]) <= DBL_EPSILON * around) {
            at[-1] = 0.0;
            break;
        }
    }
    return low;
}

int real_schur(int n, double *a, double *turned, double *work)
{
    double size = 0.0;
    int high = n - 1, steps = 0;
    size_t e;

    for (e = 0; e < (size_t)n * (size_t)n; e++)
        if (fabs(a[e]) > size)
            size = fabs(a[e]);
    identity(n, turned);
    hessenberg(n, a, turned, work);
    while (high > 0) {
        const int low = first_row(n, high, size, a);
        if (low + 1 >= high) {
            if (low + 1 == high)
                split(n, low, a, turned);
            high = low - 1;
            steps = 0;
        } else {
            const double *end = a + (size_t)high * (size_t)n + (size_t)high;
            double shift[2] = {end[-1 - n], end[0]}, crossed = end[-n] * end[-1];
            if (++steps > MOST_STEPS)
                return 1;
            if (steps % UNUSUAL_SHIFT == 0) { /* leaves a cycle */
                const double beside = fabs(end[-1]) + fabs(end[-2 - n]);
                shift[0] = shift[1] = end[0] + 0.75 * beside;
                crossed = -0.4375 * beside * beside;
            }
            francis_step(n, low, high, shift, crossed, a, turned);
        }
    }
    return 0;
}
