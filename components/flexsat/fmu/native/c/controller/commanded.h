/* Slews as commanded: their turns, begin and end, and attitudes. Part of the twin of runtime/slew_commands.py. */
#ifndef FLEXSAT_COMMANDED_H
#define FLEXSAT_COMMANDED_H

#include "slew_plans.h"

/* What a controller's state holds of its commands. */
typedef struct Commanded {
    Motion profile;        /* planned, in flight or, with `following` still, ended: the turn of the present slew */
    double turns[LEGS][3]; /* rad: the turns of the present slew after it; zero: none */
    int turns_ended;       /* of the present slew */
    Motion following;      /* the first turn of the slew after it */
    double following_turns[LEGS][3]; /* rad: the other ones */
    double origin[4];         /* attitude from which the profile turns, body from inertial */
    double base[4];           /* attitude from which the command of the profile counts */
    double following_base[4]; /* the same, of the slew after it */
    int braking;              /* the profile was braked for a new command */
    int captured;             /* the star tracker has given an attitude */
    double rotation[3];       /* rad, of the last command */
    double start;             /* s */
    double reference[CONTROLLED]; /* its first three: a quarter of the rotation since the origin */
} Commanded;

/* Between two taps of the shaper [s]. */
double shaper_spacing(const PreparedController *prepared);

/* Whether the shaped torque of a motion has begun. */
int motion_begun(const PreparedController *prepared, const Motion *motion, double time);

/* Whether no slew is planned, or the shaped torque of the one that was has ended. */
int motion_ended(const PreparedController *prepared, const Motion *motion, double time);

/* Whether the present slew has begun and its present turn has not ended. */
int slew_in_flight(const PreparedController *prepared, const Commanded *state, double time);

/* Whether a rotation vector is not zero. */
int is_turn(const double rotation[3]);

/* The first start time of a slew after the present one [s]. */
double clear_after(const PreparedController *prepared, const Commanded *state);

/* The attitude at which a motion from the present origin ends. */
void attitude_after(const Commanded *state, const Motion *motion, double attitude[4]);

/* The attitude at which the present slew ends. */
void final_attitude(const Commanded *state, double attitude[4]);

/* The turns of a slew; from an attitude that is not known yet one, which start_from checks. */
int turns_from(Component *component, const PreparedController *prepared, const Commanded *state,
               const double attitude[4], const double rotation[3], double turns[LEGS][3]);

/* Drop the first of the LEGS turns of a slew: the others move up. */
void drop_first(double (*turns)[3]);

/* Drop the slew after the present one; of a braked one all that was to follow. */
void forget_following(const PreparedController *prepared, Commanded *state);

/* Count the motion from the end of the one before, if that was flown, else from where that would have begun. */
void begin_motion(Commanded *state, const Motion *motion, int has_ended);

/* Plan a slew from an attitude at rest, in place of the present one. */
int begin_command(Component *component, const PreparedController *prepared, Commanded *state,
                  const double attitude[4], const double rotation[3], double start, double time);

#endif
