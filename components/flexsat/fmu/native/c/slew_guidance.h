/* Slew guidance: bang-coast-bang about a fixed axis, shaped for the mode that it excites most. The twin of
runtime/slew_guidance.py, which documents it. */
#ifndef FLEXSAT_SLEW_GUIDANCE_H
#define FLEXSAT_SLEW_GUIDANCE_H

/* Filter torque(t) = sum of weight times rigid torque(t + shift): zeros at one pole, unit gain at rest. */
typedef struct Shaper {
    double weights[3];
    double shifts[3]; /* s: +spacing, 0, -spacing */
} Shaper;

/* A rest-to-rest rotation about one axis with a trapezoidal rate. */
typedef struct Profile {
    double axis[3];    /* unit vector */
    double angle;      /* rad */
    double start;      /* s */
    double ramp;       /* s, duration of each of the two torque pulses */
    double coast_rate; /* rad/s */
    double coast;      /* s, between the pulses */
} Profile;

double profile_end(const Profile *profile); /* s, of the rigid manoeuvre */

/* Plan the quickest rest-to-rest rotation by a rotation vector [rad] from `start` [s], for an inertia (3, 3) [kg.m2],
within torque [N.m] and momentum [N.m.s] about each body axis. */
void plan_profile(const double rotation[3], double start, const double inertia[9], const double torque[3],
                  const double momentum[3], Profile *profile);

/* The greatest acceleration [rad/s2] and rate [rad/s] about a unit vector. */
void capability_about(const double axis[3], const double inertia[9], const double torque[3], const double momentum[3],
                      double *acceleration, double *rate);

/* The three-tap filter with zeros at a pole, frequency in rad/s, on a grid of `period` [s]. */
void shaper_for_pole(double frequency, double damping_ratio, double period, Shaper *shaper);

/* The length of a rotation vector, without overflow. */
double rotation_angle(const double rotation[3]);

#endif
