/* Errors of sensors beside white noise: biases that walk, scale, misalignment, blinding. The twin of
flexsat/sensor_errors.py and ports/sensor_errors.py, which document them. */
#ifndef FLEXSAT_SENSOR_ERRORS_H
#define FLEXSAT_SENSOR_ERRORS_H

#include <stdint.h>

#include "component.h"
#include "data.h"
#include "ports.h"
#include "random.h"

#define GYROS PORT_GYRO_RATE_SIZE
#define ACCELEROMETERS PORT_ACCELEROMETER_ACCELERATION_SIZE

enum { BLINDING = 2 }; /* sources: Sun and Earth */

/* What a step uses of the errors. */
typedef struct SensorErrors {
    const double *rate_of_gyros; /* (3, g) */
    double walk;                 /* rad/s, of a bias from one sample to the next */
    double memory, renewal;      /* of the low-frequency error; rad */
    double boresight[3];         /* unit vector, body */
    double sources[BLINDING][3]; /* unit vectors, inertial */
    double cosines[BLINDING];    /* of the half-angles; 2, which no cosine reaches, for none */
    double roll_factor;
    double misalignment[3];
    int of_gyros, walks, drifts, rolls, blinds;
} SensorErrors;

/* The errors that a run has drawn: part of the saved state. */
typedef struct ErrorState {
    Random random;
    double gyro_bias[GYROS];
    double gyro_scale[GYROS];
    double gyro_tilt[GYROS][3];
    double accelerometer_bias[ACCELEROMETERS];
    double low_frequency[3];
} ErrorState;

/* Read, check and sample. Returns 0, or 1 with the reason in `message`. */
int sensor_errors(Component *component, const SensorsData *matrices, SensorErrors *errors);

void sensor_errors_init(const Component *component, const SensorsData *matrices, ErrorState *state);

/* Add the errors of a sample to what gyros and accelerometers measure; `first`: no bias has walked before. */
void add_fast_errors(const SensorErrors *errors, int first, const double *rate, ErrorState *state, double *gyro_rate,
                     double *accelerometer);

/* Add to the noise of a sample of the star tracker what else turns it. */
void add_star_tracker_errors(const SensorErrors *errors, int first, ErrorState *state, double error[3]);

/* Whether a source stands within its half-angle of the boresight. */
int is_blinded(const SensorErrors *errors, const double body_from_inertial[4]);

#endif
