#include "null_motion.h"

#include <math.h>

#include "allocation.h"
#include "linear_algebra.h"

void prepare_null_motion(const ControllerData *matrices, const ControllerParameters *parameters, NullMotion *motion)
{
    double gram[9] = {0.0};
    int k, i, j;

    motion->rate = parameters->null_rate;
    for (k = 0; k < WHEELS; k++) {
        const int works = parameters->torque_limits[k] > 0.0;
        motion->limits[k] = works ? matrices->wheel_inertia[k] * parameters->speed_bands[k] : 0.0;
        for (i = 0; i < 3; i++)
            motion->axes[3 * k + i] = works ? matrices->wheel_axis[3 * k + i] : 0.0;
        for (i = 0; i < 3; i++)
            for (j = 0; j < 3; j++)
                gram[3 * i + j] += motion->axes[3 * k + i] * motion->axes[3 * k + j];
    }
    invert(3, gram, motion->inverse);
}

static void resultant(const NullMotion *motion, const double *momenta, double sum[3])
{
    int k, i;

    for (i = 0; i < 3; i++)
        for (sum[i] = 0.0, k = 0; k < WHEELS; k++)
            sum[i] += motion->axes[3 * k + i] * momenta[k];
}

/* The part of wheels' momenta (n) without a resultant. */
static void null_part(const NullMotion *motion, const double *momenta, double *part)
{
    double sum[3], shared[3];
    int k, i;

    resultant(motion, momenta, sum);
    times_vector(3, 3, motion->inverse, sum, shared);
    for (k = 0; k < WHEELS; k++) {
        part[k] = motion->limits[k] > 0.0 ? momenta[k] : 0.0;
        for (i = 0; i < 3; i++)
            part[k] -= motion->axes[3 * k + i] * shared[i];
    }
}

void null_torque(const NullMotion *motion, const double *momenta, const double *least, const double *most,
                 double *torque)
{
    double sum[3], aim[WHEELS], factor = 1.0;
    int k;

    resultant(motion, momenta, sum);
    for (k = 0; k < 3; k++)
        sum[k] = -sum[k];
    least_peak(motion->axes, motion->limits, sum, aim);
    for (k = 0; k < WHEELS; k++)
        aim[k] -= momenta[k];
    null_part(motion, aim, torque);
    for (k = 0; k < WHEELS; k++) {
        torque[k] *= motion->rate;
        if (torque[k] > 0.0)
            factor = fmin(factor, fmax(most[k], 0.0) / torque[k]);
        else if (torque[k] < 0.0)
            factor = fmin(factor, fmin(least[k], 0.0) / torque[k]);
    }
    for (k = 0; k < WHEELS; k++)
        torque[k] *= factor;
}
