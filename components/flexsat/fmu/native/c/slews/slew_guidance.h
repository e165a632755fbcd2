/* Slew guidance: bang-coast-bang about a fixed axis, shaped for the mode that it excites most. The twin of
runtime/slew_guidance.py, which documents it. */
#ifndef FLEXSAT_SLEW_GUIDANCE_H
#define FLEXSAT_SLEW_GUIDANCE_H

#include "component.h"
#include "controller_sizes.h"

enum { MOST_ALLOCATIONS = 3 };

/* What each wheel may give to a slew, and the ways to divide a body torque between the wheels. */
typedef struct SlewWheels {
    int count;                                       /* of divisions */
    int by_peak;                                     /* divide by the least peak of the shares, not least squares */
    double axes[WHEELS * 3];                         /* (n, 3) */
    double limits[MOST_ALLOCATIONS][WHEELS];         /* weights of the divisions, relative to the largest */
    double allocation[MOST_ALLOCATIONS][WHEELS * 3]; /* (n, 3): wheel torques of a body torque */
    double per_torque[WHEELS]; /* 1/(N.m): one over the torque that it may give; 0 for a wheel that has none */
    double per_rise[WHEELS];   /* 1/(N.m.s): one over the momentum that it can still gain */
    double per_fall[WHEELS];   /* 1/(N.m.s): one over the momentum that it can still lose */
} SlewWheels;

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

/* What wheels of unequal limits may give: axes (n, 3), torque [N.m] and momentum [N.m.s] that a slew may use, offset
[N.m.s] at rest, beside that of the nominal speed. Refuse a wheel that stands beyond its momentum, or wheels that
cannot turn the body about all axes. */
int slew_wheels(Component *component, const double *axes, const double *torque, const double *momentum,
                const double *offset, int by_peak, SlewWheels *wheels);

/* The wheel torques (n) of a body torque by one of the divisions. */
void share_torque(const SlewWheels *wheels, int division, const double torque[3], double *shares);

/* The greatest acceleration [rad/s2] and rate [rad/s] of each allocation, about an axis for which `needed` is the
inertia times it [kg.m2]. */
void limits_about(const SlewWheels *wheels, const double needed[3], double accelerations[MOST_ALLOCATIONS],
                  double rates[MOST_ALLOCATIONS]);

/* Unit vector of a rotation vector [rad], the x axis for none; returns the angle. */
double axis_of(const double rotation[3], double axis[3]);

/* The quickest rest-to-rest rotation about an axis, within acceleration [rad/s2] and rate [rad/s]. */
void plan_trapezium(const double axis[3], double angle, double start, double acceleration, double rate,
                    Profile *profile);

/* How long a rest-to-rest turn by an angle [rad] lasts [s]. */
double turn_duration(double angle, double acceleration, double rate);

/* How long a turn by an angle [rad], from an initial rate [rad/s] to rest, lasts at least [s]; the angle must be at
least that of braking from it. */
double remaining_duration(double angle, double acceleration, double rate, double initial);

/* The three-tap filter with zeros at a pole, frequency in rad/s, on a grid of `period` [s]. */
void shaper_for_pole(double frequency, double damping_ratio, double period, Shaper *shaper);

#endif
