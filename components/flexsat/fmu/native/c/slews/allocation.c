#include "allocation.h"

#include <math.h>

#define ALONG 1e-9 /* of the length of a limit's axis: less across a face is rounding */

/* What is left to divide. */
typedef struct Rest {
    double spans[WHEELS][3];
    int free[WHEELS]; /* whether a wheel's share is still open */
    double left[3];
    double across[2][3]; /* normals of the faces that are settled */
    int settled;
} Rest;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Keep a normal, of any length, if what is left needs a higher peak across its face. */
static void try_face(const Rest *rest, double normal[3], double best[3], double *peak)
{
    const double length = sqrt(dot(normal, normal));
    double reach = 0.0, needed;
    int k;

    if (!(length > ALONG))
        return;
    for (k = 0; k < 3; k++)
        normal[k] /= length;
    for (k = 0; k < WHEELS; k++)
        if (rest->free[k])
            reach += fabs(dot(normal, rest->spans[k]));
    needed = dot(normal, rest->left) / reach;
    if (fabs(needed) > fabs(*peak)) {
        *peak = needed;
        for (k = 0; k < 3; k++)
            best[k] = normal[k];
    }
}

/* The normal of the face by which what is left leaves, and the peak that it needs, with its sign. */
static double find_face(const Rest *rest, double best[3])
{
    double normal[3], peak = 0.0;
    int i, j;

    if (rest->settled == 2) { /* along one axis */
        cross(rest->across[0], rest->across[1], normal);
        try_face(rest, normal, best, &peak);
        return peak;
    }
    for (i = 0; i < WHEELS; i++) {
        if (!rest->free[i])
            continue;
        if (rest->settled == 1) {
            cross(rest->across[0], rest->spans[i], normal);
            try_face(rest, normal, best, &peak);
            continue;
        }
        for (j = i + 1; j < WHEELS; j++)
            if (rest->free[j]) {
                cross(rest->spans[i], rest->spans[j], normal);
                try_face(rest, normal, best, &peak);
            }
    }
    return peak;
}

/* Give the wheels across a face their share. */
static void settle(Rest *rest, const double normal[3], double peak, double *share)
{
    const double left[3] = {rest->left[0], rest->left[1], rest->left[2]};
    double given[3] = {0.0, 0.0, 0.0};
    int i, k;

    for (k = 0; k < WHEELS; k++) {
        const double crossing = dot(rest->spans[k], normal);
        if (!rest->free[k] || !(fabs(crossing) > ALONG))
            continue;
        share[k] = crossing > 0.0 ? peak : -peak;
        rest->free[k] = 0;
        for (i = 0; i < 3; i++)
            given[i] += share[k] * rest->spans[k][i];
    }
    for (i = 0; i < 3; i++)
        rest->left[i] = left[i] - given[i];
}

void least_peak(const double *axes, const double *limits, const double torque[3], double *result)
{
    Rest rest = {.settled = 0};
    double scale = 0.0, normal[3] = {0.0, 0.0, 0.0};
    int i, k;

    for (k = 0; k < WHEELS; k++) {
        result[k] = 0.0;
        for (i = 0; i < 3; i++)
            rest.spans[k][i] = axes[3 * k + i] * limits[k];
        scale = fmax(scale, sqrt(dot(rest.spans[k], rest.spans[k])));
    }
    for (i = 0; i < 3; i++)
        rest.left[i] = -torque[i] / scale;
    for (k = 0; k < WHEELS; k++) {
        for (i = 0; i < 3; i++)
            rest.spans[k][i] /= scale;
        rest.free[k] = sqrt(dot(rest.spans[k], rest.spans[k])) > ALONG;
    }
    for (; rest.settled < 3; rest.settled++) {
        const double peak = find_face(&rest, normal);
        if (peak == 0.0)
            break;
        settle(&rest, normal, peak, result);
        if (rest.settled < 2)
            for (i = 0; i < 3; i++)
                rest.across[rest.settled][i] = normal[i];
    }
    for (k = 0; k < WHEELS; k++)
        result[k] *= limits[k];
}
