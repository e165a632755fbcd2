#include "wheel_jitter.h"

#include <math.h>

void harmonic_jitter(int n, const double *speed, const double *angle, double hold, double force, double torque,
                     double *jitter)
{
    int k;

    for (k = 0; k < n; k++) {
        const double middle = angle[k] + 0.5 * hold * speed[k], square = speed[k] * speed[k];
        const double sine = sin(middle) * square, cosine = cos(middle) * square;
        jitter[k] = sine * force;
        jitter[n + k] = cosine * force;
        jitter[2 * n + k] = cosine * -torque;
        jitter[3 * n + k] = sine * torque;
    }
}
