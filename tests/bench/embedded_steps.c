/* Time of each step of the exported controller, by the processor time of its thread: what other programs take does not
count, what they evict from the caches does. Linked with an export and its rigid spacecraft. Prints for each case how
many steps, then the median, 99.9 % and longest [us]; first what flexsat_prepare took [us]. */
#define _POSIX_C_SOURCE 200809L
#include "flexsat_names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "flexsat_controller.h"
#include "rigid_spacecraft.h"

enum { STEPS = 24000, STAR_TRACKER_EVERY = 20, COMMAND = 2000 };

static double memory[FLEXSAT_MEMORY_SIZE / sizeof(double)];
static RigidSpacecraft spacecraft;
static double spent[STEPS];

static double now(void)
{
    struct timespec time;

    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e6 * (double)time.tv_sec + 1e-3 * (double)time.tv_nsec;
}

static int compare(const void *one, const void *other)
{
    const double a = *(const double *)one, b = *(const double *)other;

    return (a > b) - (a < b);
}

/* Fly with a slew that is commanded on the way; print the times of all steps but that of the command, and this one. */
static void fly(const char *name, const FlexsatParameters *parameters)
{
    FlexsatInputs inputs = {0};
    FlexsatOutputs outputs = {0};
    const char *reason;
    double begun = now(), planned = 0.0;
    FlexsatController *controller = flexsat_prepare(parameters, memory, sizeof memory, &reason);
    const double prepared = now() - begun;
    long tick;

    inputs.command_start_time = 5.0;
    if (controller == NULL || flexsat_init(controller, inputs.command_rotation, inputs.command_start_time)) {
        fprintf(stderr, "embedded_steps: %s: %s\n", name, reason);
        exit(1);
    }
    spacecraft_start(&spacecraft, &controller_corrected);
    for (tick = 0; tick < STEPS; tick++) {
        spacecraft_measure(&spacecraft, tick % STAR_TRACKER_EVERY == 0, &inputs);
        if (tick == COMMAND) {
            inputs.command_rotation[0] = 0.5 * 3.14159265358979 / 180.0;
            inputs.command_start_time = 12.0;
        }
        begun = now();
        if (flexsat_step(controller, &inputs, &outputs) != FLEXSAT_OK) {
            fprintf(stderr, "embedded_steps: %s: step %ld: %s\n", name, tick, reason);
            exit(1);
        }
        spent[tick] = now() - begun;
        spacecraft_move(&spacecraft, outputs.wheel_torque, FLEXSAT_PERIOD);
    }
    planned = spent[COMMAND];
    spent[COMMAND] = spent[COMMAND - 1];
    qsort(spent, STEPS, sizeof *spent, compare);
    printf("  %-28s prepare %9.0f us, step %7.2f us, 99.9 %% %7.2f us, longest %7.2f us, with a new command %9.1f us\n",
           name, prepared, spent[STEPS / 2], spent[STEPS - 1 - STEPS / 1000], spent[STEPS - 1], planned);
}

int main(void)
{
    FlexsatParameters parameters = flexsat_default_parameters;

    fly("default", &parameters);
    parameters.reference_smoothed = 1;
    fly("smoothed reference", &parameters);
    parameters.reference_smoothed = 0;
    parameters.delay_measurement = parameters.delay_actuation = 0.02;
    fly("delays of 20 ms and 20 ms", &parameters);
    parameters.delay_measurement = parameters.delay_actuation = 0.0;
    parameters.slew_guidance = FLEXSAT_QP;
    fly("quadratic programme", &parameters);
    parameters.slew_guidance = FLEXSAT_BANG_COAST_BANG;
    parameters.keep_out_first_direction[1] = -0.0043; /* the axis is turned through it: a chain leads round */
    parameters.keep_out_first_direction[2] = 1.0;
    parameters.keep_out_first_half_angle = 0.001;
    fly("round a cone", &parameters);
    return 0;
}
