/* The sensors' parameters of one run, from their ports: twin of runtime/sensor_parameters.py and ports/sensors.py. */
#ifndef FLEXSAT_SENSOR_PARAMETERS_H
#define FLEXSAT_SENSOR_PARAMETERS_H

#include <stdint.h>

#include "component.h"
#include "ports.h"

#define WHEELS PORT_WHEEL_SPEED_SIZE

/* Deviations are standard deviations of one sample. */
typedef struct SensorParameters {
    double gyro_noise;                /* rad/s */
    double accelerometer_noise;       /* m/s2 */
    int accelerometer_noise_is_gyros; /* slip of the release: the gyros' number, read in m/s2 */
    double encoder_noise;             /* rad/s */
    double star_tracker_noise;        /* rad, each axis */
    double filter_frequency;          /* Hz, of the accelerometers' Butterworth filter */
    double step;                      /* s */
    int64_t fast_steps;               /* between samples of gyros, accelerometers and encoders */
    int64_t star_tracker_steps;       /* between samples of the star tracker */
    int jitter;
    double imbalance_force[WHEELS];   /* N.s2/rad2 */
    double imbalance_torque[WHEELS];  /* N.m.s2/rad2 */
    double broadband_force[WHEELS];   /* N, held over fast_steps */
    double broadband_torque[WHEELS];  /* N.m */
} SensorParameters;

/* Read and check them, for steps of this length [s]; 0: that of the parameter step_size. Where neither gives it, it
is not known before the first step, and what depends on it is as if the fastest instruments were sampled each step.
Returns 0, or 1 with the reason in `message`. */
int sensor_parameters(Component *component, double step, SensorParameters *parameters);

#endif
