#include "wheel_jitter.h"

void harmonic_jitter(Sines *sines, int n, const double *speed, const double *angle, double hold, const double *force,
                     const double *torque, double *jitter)
{
    double *middle = jitter, *sine = jitter + n, *cosine = jitter + 2 * n;
    int k;

    for (k = 0; k < n; k++)
        middle[k] = angle[k] + 0.5 * hold * speed[k];
    sines(n, middle, sine, cosine);
    for (k = 0; k < n; k++) {
        const double square = speed[k] * speed[k], first = sine[k] * square, second = cosine[k] * square;
        jitter[k] = first * force[k];
        jitter[n + k] = second * force[k];
        jitter[2 * n + k] = second * -torque[k];
        jitter[3 * n + k] = first * torque[k];
    }
}

void add_harmonics(const Harmonics *harmonics, Sines *sines, int n, const double *speed, const double *angle,
                   double hold, const double *factor, double *scratch, double *jitter)
{
    double *middle = scratch, *sine = scratch + n, *cosine = scratch + 2 * n;
    int i, k;

    for (i = 0; i < harmonics->count; i++) {
        const int row = i * n;
        for (k = 0; k < n; k++)
            middle[k] = harmonics->order[row + k] * (angle[k] + 0.5 * hold * speed[k]) + harmonics->phase[row + k];
        sines(n, middle, sine, cosine);
        for (k = 0; k < n; k++) {
            const double square = speed[k] * speed[k] * factor[k];
            const double first = sine[k] * square, second = cosine[k] * square;
            jitter[k] += first * harmonics->force[row + k];
            jitter[n + k] += second * harmonics->force[row + k];
            jitter[2 * n + k] -= second * harmonics->torque[row + k];
            jitter[3 * n + k] += first * harmonics->torque[row + k];
        }
    }
}
