/* The law of the foreign controller: a PD on attitude and rate; the last valid attitude is held. */

#include <math.h>

#define STEP 0.01
#define WHEELS 6
#define DEGREE 0.017453292519943295

static const double AXIS[WHEELS][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
static const double INERTIA[3] = {217.7e3, 217.7e3, 435.4e3}; /* [kg.m2] */

typedef struct {
    double kp, kd, limit; /* [1/s2], [1/s], [mN.m] */
} Gains;

/* `q` is inertial from body, scalar first, and counts if `valid` is 3; `rate` is in deg/s, `torque` in mN.m. */
static void control(const Gains *gains, const double *q, const double *rate, int valid, int mode, double *angle,
                    double *torque) {
    double side = q[0] < 0 ? -1 : 1, body[3];
    if (valid == 3) {
        for (int k = 0; k < 3; k++) angle[k] = -2 * side * q[1 + k];
    }
    for (int k = 0; k < 3; k++) body[k] = -INERTIA[k] * (gains->kp * angle[k] + gains->kd * rate[k] * DEGREE);
    for (int w = 0; w < WHEELS; w++) {
        double sum = 0; /* of each pair of opposite wheels, one half */
        for (int k = 0; k < 3; k++) sum -= 0.5 * AXIS[w][k] * body[k];
        sum = fmax(-gains->limit, fmin(gains->limit, 1e3 * sum));
        torque[w] = mode == 2 ? sum : 0;
    }
}
