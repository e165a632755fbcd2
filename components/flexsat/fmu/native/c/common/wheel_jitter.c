#include "wheel_jitter.h"

void harmonic_jitter(Sines *sines, int n, const double *speed, const double *angle, double hold, double force,
                     double torque, double *jitter)
{
    double *middle = jitter, *sine = jitter + n, *cosine = jitter + 2 * n;
    int k;

    for (k = 0; k < n; k++)
        middle[k] = angle[k] + 0.5 * hold * speed[k];
    sines(n, middle, sine, cosine);
    for (k = 0; k < n; k++) {
        const double square = speed[k] * speed[k], first = sine[k] * square, second = cosine[k] * square;
        jitter[k] = first * force;
        jitter[n + k] = second * force;
        jitter[2 * n + k] = second * -torque;
        jitter[3 * n + k] = first * torque;
    }
}
