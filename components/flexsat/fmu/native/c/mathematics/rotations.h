/* Attitudes, each mapping inertial to body components: the twin of runtime/rotations.py. Quaternions are scalar-last.
A result may be the same array as an argument. */
#ifndef FLEXSAT_ROTATIONS_H
#define FLEXSAT_ROTATIONS_H

void quaternion_from_mrp(const double mrp[3], double quaternion[4]);
void mrp_from_quaternion(const double quaternion[4], double mrp[3]); /* of the short rotation */

/* The rotation `first`, followed by `second`. */
void compose_quaternions(const double second[4], const double first[4], double quaternion[4]);

void quaternion_from_rotation_vector(const double rotation[3], double quaternion[4]); /* [rad] */
void rotation_vector(const double quaternion[4], double rotation[3]);                 /* [rad], of the short rotation */

/* The rotation from the attitude `base` to another, in body axes. */
void relative_quaternion(const double quaternion[4], const double base[4], double relative[4]);
void relative_mrp(const double quaternion[4], const double base[4], double mrp[3]);

/* Turn an attitude further by a rotation vector [rad] in body axes; the quaternion's norm is 1. */
void rotate_quaternion(const double quaternion[4], const double rotation[3], double turned[4]);
void rotate_mrp(const double mrp[3], const double rotation[3], double turned[3]);

void matrix_from_mrp(const double mrp[3], double matrix[9]); /* direction cosines, row after row */

#endif
