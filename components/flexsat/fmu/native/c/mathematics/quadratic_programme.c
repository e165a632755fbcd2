#include "quadratic_programme.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"

enum { N = OPTIMUM_STEPS, M = OPTIMUM_BOUNDS, ITERATIONS = 60 };

#define DONE 1e-12        /* of the duality gap, relative to the cost's gradient */
#define STATIONARY 1e-6   /* of the Lagrangian's gradient: rounding of multipliers that no unique value has, 1e-8 */
#define KEPT 1e-9         /* what the constraints are missed by, in units of the bounds */
#define STEP_SHARE 0.99   /* of the longest step that keeps the values positive */

Optimum *optimum_take(Memory *memory)
{
    Optimum *work = memory_take(memory, 1, sizeof *work);
    double *quadratic = memory_doubles(memory, N * N), *factor = memory_doubles(memory, N * N);

    if (memory->failed)
        return NULL;
    work->quadratic = quadratic;
    work->factor = factor;
    return work;
}

void to_rates(const Optimum *work, const double *x, double *y)
{
    double sum = 0.0;
    int i;

    for (i = 0; i < N; i++)
        y[i] = sum += work->unit[i] * x[i];
}

/* y (n) = the transpose of R, times z; rows from `rows` on are not there. */
static void from_rates(const Optimum *work, int rows, const double *z, double *y)
{
    double sum = 0.0;
    int j;

    for (j = N - 1; j >= 0; j--) {
        if (j < rows)
            sum += z[j];
        y[j] = work->unit[j] * sum;
    }
}

/* z (m) = C x: changes of rate both ways, then rates both ways, over their bounds */
static void inequalities(const Optimum *work, const double *x, double *z)
{
    double rates[N];
    int k;

    to_rates(work, x, rates);
    for (k = 0; k < N; k++) {
        z[k] = x[k];
        z[N + k] = -x[k];
    }
    for (k = 0; k < N - 1; k++) {
        z[2 * N + k] = rates[k] / work->most;
        z[3 * N - 1 + k] = -rates[k] / work->most;
    }
}

/* y (n) = the transpose of C, times z (m) */
static void transposed(const Optimum *work, const double *z, double *y)
{
    double difference[N], through[N];
    int k;

    for (k = 0; k < N - 1; k++)
        difference[k] = (z[2 * N + k] - z[3 * N - 1 + k]) / work->most;
    from_rates(work, N - 1, difference, through);
    for (k = 0; k < N; k++)
        y[k] = z[k] - z[N + k] + through[k];
}

/* Solve with the Cholesky factor in place. */
static void solve_factored(const double *factor, double *x)
{
    int i, j;

    for (i = 0; i < N; i++) {
        double sum = x[i];
        for (j = 0; j < i; j++)
            sum -= factor[i * N + j] * x[j];
        x[i] = sum / factor[i * N + i];
    }
    for (i = N - 1; i >= 0; i--) {
        const double value = x[i] /= factor[i * N + i];
        for (j = 0; j < i; j++)
            x[j] -= factor[i * N + j] * value;
    }
}

static double product(int n, const double *a, const double *b)
{
    double sum = 0.0;
    int k;

    for (k = 0; k < n; k++)
        sum += a[k] * b[k];
    return sum;
}

/* Factor the quadratic cost with the barriers, and what the end couples; returns 0, or 1 if it has no factor. */
static int factorise(Optimum *work)
{
    double tail = 0.0;
    int j, l, k;

    for (j = N - 1; j >= 0; j--) {
        if (j < N - 1)
            tail += (work->ratio[2 * N + j] + work->ratio[3 * N - 1 + j]) / (work->most * work->most);
        for (l = 0; l <= j; l++)
            work->factor[j * N + l] = work->quadratic[j * N + l] + work->unit[j] * work->unit[l] * tail;
        work->factor[j * N + j] += work->ratio[j] + work->ratio[N + j];
    }
    if (cholesky(N, work->factor))
        return 1;
    memcpy(work->along_end, work->end, sizeof work->end);
    for (k = 0; k < 2; k++)
        solve_factored(work->factor, work->along_end + k * N);
    work->square[0] = product(N, work->end, work->along_end);
    work->square[1] = product(N, work->end, work->along_end + N);
    work->square[2] = product(N, work->end + N, work->along_end + N);
    return 0;
}

/* The step (dx, ds, dz, dy) for these products of slack and dual. */
static void find_direction(Optimum *work)
{
    const double *square = work->square, determinant = square[0] * square[2] - square[1] * square[1];
    double push[M], right[2];
    int k;

    for (k = 0; k < M; k++)
        push[k] = work->ratio[k] * work->inside[k] - work->complementary[k] / work->slack[k];
    transposed(work, push, work->dx);
    for (k = 0; k < N; k++)
        work->dx[k] = -work->stationary[k] - work->dx[k];
    solve_factored(work->factor, work->dx);
    for (k = 0; k < 2; k++)
        right[k] = product(N, work->end + k * N, work->dx) + work->on[k];
    work->dy[0] = (square[2] * right[0] - square[1] * right[1]) / determinant;
    work->dy[1] = (square[0] * right[1] - square[1] * right[0]) / determinant;
    for (k = 0; k < N; k++)
        work->dx[k] -= work->along_end[k] * work->dy[0] + work->along_end[N + k] * work->dy[1];
    inequalities(work, work->dx, push);
    for (k = 0; k < M; k++) {
        work->ds[k] = -work->inside[k] - push[k];
        work->dz[k] = -(work->complementary[k] + work->dual[k] * work->ds[k]) / work->slack[k];
    }
}

/* The longest step, up to 1 / STEP_SHARE, that keeps slack and dual positive. */
static double longest(const Optimum *work)
{
    double length = 1.0 / STEP_SHARE;
    int k;

    for (k = 0; k < M; k++) {
        if (work->ds[k] < 0.0)
            length = fmin(length, -work->slack[k] / work->ds[k]);
        if (work->dz[k] < 0.0)
            length = fmin(length, -work->dual[k] / work->dz[k]);
    }
    return length;
}

static double largest(int n, const double *values)
{
    double most = 0.0;
    int k;

    for (k = 0; k < n; k++)
        most = fmax(most, fabs(values[k]));
    return most;
}

/* What is missed by the present values. */
static void evaluate(Optimum *work)
{
    double of_duals[N];
    int k;

    times_vector(N, N, work->quadratic, work->x, work->stationary);
    transposed(work, work->dual, of_duals);
    for (k = 0; k < N; k++)
        work->stationary[k] += work->linear[k] + of_duals[k] + work->end[k] * work->multiplier[0] +
                               work->end[N + k] * work->multiplier[1];
    inequalities(work, work->x, work->inside);
    for (k = 0; k < M; k++)
        work->inside[k] += work->slack[k] - work->bounds[k];
    for (k = 0; k < 2; k++)
        work->on[k] = product(N, work->end + k * N, work->x) - work->end_value[k];
}

/* Predict and correct: one step of Mehrotra's method. Returns 0, or 1 if there is none. */
static int improve(Optimum *work, double gap)
{
    double ahead, after = 0.0, length, share;
    int k;

    for (k = 0; k < M; k++) {
        work->ratio[k] = work->dual[k] / work->slack[k];
        work->complementary[k] = work->slack[k] * work->dual[k];
    }
    if (factorise(work))
        return 1;
    find_direction(work);
    ahead = longest(work);
    for (k = 0; k < M; k++)
        after += (work->slack[k] + ahead * work->ds[k]) * (work->dual[k] + ahead * work->dz[k]);
    share = after / M / gap;
    for (k = 0; k < M; k++)
        work->complementary[k] += work->ds[k] * work->dz[k] - share * share * share * gap;
    find_direction(work);
    length = STEP_SHARE * longest(work);
    for (k = 0; k < N; k++)
        work->x[k] += length * work->dx[k];
    for (k = 0; k < M; k++) {
        work->slack[k] += length * work->ds[k];
        work->dual[k] += length * work->dz[k];
    }
    for (k = 0; k < 2; k++)
        work->multiplier[k] += length * work->dy[k];
    return 0;
}

int minimise(Optimum *work)
{
    const double scale = largest(N, work->linear);
    int k;

    memset(work->x, 0, sizeof work->x);
    memset(work->multiplier, 0, sizeof work->multiplier);
    for (k = 0; k < M; k++)
        work->slack[k] = work->dual[k] = 1.0;
    for (k = 0; k < ITERATIONS; k++) {
        double gap;
        evaluate(work);
        gap = product(M, work->slack, work->dual) / M;
        if (gap < DONE * scale && largest(N, work->stationary) < STATIONARY * scale &&
            fmax(largest(M, work->inside), largest(2, work->on)) < KEPT)
            return 0;
        if (improve(work, gap))
            return 1;
    }
    return 1;
}
