/* Sizes of the controller, which those of its ports give. */
#ifndef FLEXSAT_CONTROLLER_SIZES_H
#define FLEXSAT_CONTROLLER_SIZES_H

#include "ports.h"

enum {
    GYROS = PORT_GYRO_RATE_SIZE,
    ACCELEROMETERS = PORT_ACCELEROMETER_ACCELERATION_SIZE,
    WHEELS = PORT_WHEEL_TORQUE_SIZE,
    MODES = PORT_REFERENCE_MODAL_DISPLACEMENT_SIZE,
    CONTROLLED = 6 + 2 * MODES + WHEELS, /* p, eta, w, eta', wheel speed less nominal */
    STATES = CONTROLLED + 2 * ACCELEROMETERS, /* and the filter's */
    TORQUES = 3,
    SLOW = TORQUES + GYROS, /* torque on the body, and the bias of each gyro */
    MEASURED = GYROS + ACCELEROMETERS + WHEELS + 3
};

#endif
