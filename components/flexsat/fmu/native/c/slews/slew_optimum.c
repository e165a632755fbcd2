#include "slew_optimum.h"

#include <math.h>
#include <string.h>

enum { N = OPTIMUM_STEPS };

#define RATE_WEIGHT 1.0   /* s2, of the rate error squared; without it the optimum overshoots */

static void spread(double from, double to, int steps, double *times)
{
    const double step = (to - from) / steps;
    int k;

    for (k = 0; k < steps; k++)
        times[k] = k * step + from;
    times[steps] = to;
}

void optimum_times(double duration, double ramp, double times[OPTIMUM_KNOTS])
{
    const double end = duration + OPTIMUM_TAIL;
    const int quarter = N / 4;

    if (duration <= 8.0 * ramp + OPTIMUM_TAIL) {
        spread(0.0, end, N, times);
        return;
    }
    spread(0.0, 2.0 * ramp, quarter, times);
    spread(2.0 * ramp, duration - 2.0 * ramp, quarter, times + quarter);
    spread(duration - 2.0 * ramp, end, N - 2 * quarter, times + 2 * quarter);
}

/* Angles at the knots 1..n of changes of rate, as a matrix (n, n): straight lines between the rates. */
static void fill_angles(const Optimum *work, double *angles)
{
    int i, j;

    memset(angles, 0, N * N * sizeof(double));
    for (i = 0; i < N; i++)
        for (j = 0; j <= i; j++) {
            const double mean = j < i ? work->unit[j] : 0.5 * work->unit[j];
            angles[i * N + j] = mean * work->steps[i] + (i > 0 ? angles[(i - 1) * N + j] : 0.0);
        }
}

/* The cost of attitude and rate errors, weighted by the length of a step; its angles are those of `factor`. */
static void prepare_cost(Optimum *work, const double times[OPTIMUM_KNOTS], double first)
{
    const double *angles = work->factor;
    double weight[N], tail[N], total = 0.0;
    int i, j, l;

    for (i = 0; i < N; i++)
        total += work->steps[i];
    for (i = 0; i < N; i++)
        weight[i] = work->steps[i] / total;
    memset(work->quadratic, 0, N * N * sizeof(double));
    memset(work->linear, 0, sizeof work->linear);
    for (i = 0; i < N; i++) {
        const double *row = angles + i * N, coasted = first * times[i + 1]; /* that the initial rate alone turns */
        for (j = 0; j <= i; j++) {
            const double weighted = 2.0 * weight[i] * row[j];
            for (l = 0; l <= j; l++)
                work->quadratic[j * N + l] += weighted * row[l];
            work->linear[j] += weighted * (coasted - 1.0);
        }
    }
    for (i = N - 1; i >= 0; i--)
        tail[i] = weight[i] + (i + 1 < N ? tail[i + 1] : 0.0);
    for (j = 0; j < N; j++) {
        work->linear[j] += 2.0 * RATE_WEIGHT * first * work->unit[j] * tail[j];
        for (l = 0; l <= j; l++) {
            work->quadratic[j * N + l] += 2.0 * RATE_WEIGHT * work->unit[j] * work->unit[l] * tail[j];
            work->quadratic[l * N + j] = work->quadratic[j * N + l];
        }
    }
}

static void prepare(Optimum *work, double angle, double acceleration, double rate,
                    const double times[OPTIMUM_KNOTS], double initial)
{
    const double most = rate / angle, first = initial / angle;
    int k;

    work->most = most;
    for (k = 0; k < N; k++) {
        work->steps[k] = times[k + 1] - times[k];
        /* over a step that could pass the whole range of rates, the range is the bound */
        work->unit[k] = fmin(acceleration / angle * work->steps[k], most);
    }
    fill_angles(work, work->factor);
    prepare_cost(work, times, first);
    for (k = 0; k < N; k++) {
        work->end[k] = work->factor[(N - 1) * N + k];
        work->end[N + k] = work->unit[k] / most;
    }
    work->end_value[0] = 1.0 - first * times[N];
    work->end_value[1] = -first / most;
    for (k = 0; k < 2 * N; k++)
        work->bounds[k] = 1.0;
    for (k = 0; k < N - 1; k++) {
        work->bounds[2 * N + k] = 1.0 - first / most;
        work->bounds[3 * N - 1 + k] = first / most; /* no overshoot, the optimum of a slew of long ramps */
    }
}

int optimal_rates(Optimum *work, double angle, double acceleration, double rate, const double times[OPTIMUM_KNOTS],
                  double initial, double rates[OPTIMUM_KNOTS])
{
    int k;

    prepare(work, angle, acceleration, rate, times, initial);
    if (minimise(work))
        return 1;
    to_rates(work, work->x, rates + 1);
    rates[0] = fmax(initial, 0.0);
    for (k = 1; k < N; k++)
        rates[k] = fmax(initial + angle * rates[k], 0.0); /* zero but for what the method leaves */
    rates[N] = 0.0;
    return 0;
}
