#include "rotations.h"

#include <math.h>

void quaternion_from_mrp(const double mrp[3], double quaternion[4])
{
    const double x = mrp[0], y = mrp[1], z = mrp[2];
    const double square = x * x + y * y + z * z;
    const double scale = 1.0 / (1.0 + square);

    quaternion[0] = 2.0 * x * scale;
    quaternion[1] = 2.0 * y * scale;
    quaternion[2] = 2.0 * z * scale;
    quaternion[3] = (1.0 - square) * scale;
}

void mrp_from_quaternion(const double quaternion[4], double mrp[3])
{
    const double w = quaternion[3];
    const double scale = w >= 0.0 ? 1.0 / (1.0 + w) : -1.0 / (1.0 - w);
    int k;

    for (k = 0; k < 3; k++)
        mrp[k] = quaternion[k] * scale;
}

void compose_quaternions(const double second[4], const double first[4], double quaternion[4])
{
    const double x2 = second[0], y2 = second[1], z2 = second[2], w2 = second[3];
    const double x1 = first[0], y1 = first[1], z1 = first[2], w1 = first[3];

    quaternion[0] = w1 * x2 + w2 * x1 - (y2 * z1 - z2 * y1);
    quaternion[1] = w1 * y2 + w2 * y1 - (z2 * x1 - x2 * z1);
    quaternion[2] = w1 * z2 + w2 * z1 - (x2 * y1 - y2 * x1);
    quaternion[3] = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2;
}

void quaternion_from_rotation_vector(const double rotation[3], double quaternion[4])
{
    const double x = rotation[0], y = rotation[1], z = rotation[2];
    const double angle = sqrt(x * x + y * y + z * z);
    const double half = 0.5 * angle;
    /* sin(x)/x loses nothing to its series below 1e-4: the next term is under 1e-17 */
    const double scale = angle > 1e-4 ? sin(half) / angle : 0.5 - angle * angle / 48.0;

    quaternion[0] = x * scale;
    quaternion[1] = y * scale;
    quaternion[2] = z * scale;
    quaternion[3] = cos(half);
}

void rotation_vector(const double quaternion[4], double rotation[3])
{
    const double x = quaternion[0], y = quaternion[1], z = quaternion[2], w = quaternion[3];
    const double sine = sqrt(x * x + y * y + z * z);
    double scale = 0.0;
    int k;

    if (sine > 0.0)
        scale = 2.0 * atan2(sine, fabs(w)) / sine;
    if (w < 0.0)
        scale = -scale;
    for (k = 0; k < 3; k++)
        rotation[k] = quaternion[k] * scale;
}

void relative_quaternion(const double quaternion[4], const double base[4], double relative[4])
{
    const double back[4] = {-base[0], -base[1], -base[2], base[3]};

    compose_quaternions(quaternion, back, relative);
}

void relative_mrp(const double quaternion[4], const double base[4], double mrp[3])
{
    double relative[4];

    relative_quaternion(quaternion, base, relative);
    mrp_from_quaternion(relative, mrp);
}

void rotate_quaternion(const double quaternion[4], const double rotation[3], double turned[4])
{
    double turn[4], scale;
    int k;

    quaternion_from_rotation_vector(rotation, turn);
    compose_quaternions(turn, quaternion, turn);
    scale = 1.0 / sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
    for (k = 0; k < 4; k++)
        turned[k] = turn[k] * scale;
}

void rotate_mrp(const double mrp[3], const double rotation[3], double turned[3])
{
    double turn[4], attitude[4];

    quaternion_from_rotation_vector(rotation, turn);
    quaternion_from_mrp(mrp, attitude);
    compose_quaternions(turn, attitude, attitude);
    mrp_from_quaternion(attitude, turned);
}

void matrix_from_mrp(const double mrp[3], double matrix[9])
{
    double q[4];

    quaternion_from_mrp(mrp, q);
    matrix[0] = q[3] * q[3] + q[0] * q[0] - q[1] * q[1] - q[2] * q[2];
    matrix[1] = 2.0 * (q[0] * q[1] + q[3] * q[2]);
    matrix[2] = 2.0 * (q[0] * q[2] - q[3] * q[1]);
    matrix[3] = 2.0 * (q[0] * q[1] - q[3] * q[2]);
    matrix[4] = q[3] * q[3] - q[0] * q[0] + q[1] * q[1] - q[2] * q[2];
    matrix[5] = 2.0 * (q[1] * q[2] + q[3] * q[0]);
    matrix[6] = 2.0 * (q[0] * q[2] + q[3] * q[1]);
    matrix[7] = 2.0 * (q[1] * q[2] - q[3] * q[0]);
    matrix[8] = q[3] * q[3] - q[0] * q[0] - q[1] * q[1] + q[2] * q[2];
}
