/* The planned rotation about one axis as a piecewise linear rate, whatever guidance planned it. The twin of
runtime/slew_motion.py, which documents it. */
#ifndef FLEXSAT_SLEW_MOTION_H
#define FLEXSAT_SLEW_MOTION_H

#include "slew_guidance.h"
#include "slew_optimum.h"

enum {
    BRAKED = 4, /* knots more than those of a profile: where it is braked, and where it stops; and two to spare */
    MOST_KNOTS = BRAKED + 2 * OPTIMUM_KNOTS
};

/* A rotation that begins and ends at rest; no slew has the angle 0. Copied with the state: no pointers. */
typedef struct Motion {
    double axis[3]; /* unit vector, fixed in the body */
    double angle;   /* rad, turned by the torque that is held over periods */
    double before;  /* rad, turned before the first knot by the torque that is held, over the scale */
    double start;   /* s */
    double end;     /* s */
    double scale;   /* of the rate that is flown: a torque held over periods then turns by the angle */
    int allocation; /* of the torque to the wheels */
    int count;      /* knots in use; the rate is constant before and after them */
    int knots;      /* that it may have */
    double times[MOST_KNOTS];  /* s, increasing */
    double rates[MOST_KNOTS];  /* rad/s */
    double turned[MOST_KNOTS]; /* rad: integral of the rate */
} Motion;

double motion_rate(const Motion *motion, double time);     /* rad/s */
double motion_rotation(const Motion *motion, double time); /* rad: the integral of the rate */

/* No slew. */
void motion_still(int knots, double start, Motion *motion);

/* When a run samples, and how long a motion that was changed is still needed as it was. */
typedef struct Sampling {
    double period; /* s */
    double phase;  /* s: samples are there and whole periods from it */
    double memory; /* s: for all taps of the shaper */
} Sampling;

/* A trapezium, whose torque will be held over periods. */
void motion_from_profile(const Profile *profile, int knots, const Sampling *sampling, int allocation, Motion *motion);

/* The motion with `count` of these rates, scaled so that held torques turn by exactly the profile's angle. */
void motion_from_knots(const Profile *profile, int count, const double *times, const double *rates, int knots,
                       const Sampling *sampling, int allocation, Motion *motion);

/* Change the rates from a sample at `time` [s] on to `count` others, at `since` [s] after it, the first at 0 with the
rate that is flown then; `angle` [rad] is where held torques will end, or NULL: wherever that is. Returns 1 if it is
done, and 0 if the knots do not suffice. */
int motion_continue(Motion *motion, double time, int count, const double *since, const double *rates,
                    const double *angle, const Sampling *sampling);

/* Brake from `time` [s] on [rad/s2], unless it would not end earlier. */
void motion_stop(Motion *motion, double time, double deceleration, const Sampling *sampling);

/* The change of rate [rad/s] that the shaped torque makes over [time, time + period) [s]. */
double shaped_rate_change(const Motion *motion, const Shaper *shaper, double time, double period);

#endif
