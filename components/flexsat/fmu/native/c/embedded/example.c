/* The controller in a loop of a fixed rate, on a host: `./example [SECONDS]`.

A target replaces the three functions below: it waits for its timer, reads its sensors and commands its wheels. Here a
rigid spacecraft is turned by half a degree. Printed are attitude errors, and what a step of the controller cost. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "flexsat_controller.h"
#include "rigid_spacecraft.h"

#define ARCSECOND 4.84813681109536e-6 /* rad */

enum { STAR_TRACKER_EVERY = 20 }; /* steps: 10 Hz */

static double memory[FLEXSAT_MEMORY_SIZE / sizeof(double)]; /* aligned as a double is */
static unsigned char saved[FLEXSAT_STATE_SIZE];
static RigidSpacecraft spacecraft;

/* A target returns at the next interrupt of its timer. A host need not wait. */
static void wait_for_tick(long tick)
{
    (void)tick;
}

static void read_sensors(long tick, FlexsatInputs *inputs)
{
    spacecraft_measure(&spacecraft, tick % STAR_TRACKER_EVERY == 0, inputs);
}

static void command_wheels(const FlexsatOutputs *outputs)
{
    spacecraft_move(&spacecraft, outputs->wheel_torque, FLEXSAT_PERIOD);
}

int main(int argument_count, char **arguments)
{
    const double duration = argument_count > 1 ? atof(arguments[1]) : 130.0;
    const long ticks = (long)(duration / FLEXSAT_PERIOD + 0.5);
    FlexsatParameters parameters = flexsat_default_parameters;
    FlexsatInputs inputs = {0};
    FlexsatOutputs outputs = {0};
    FlexsatController *controller;
    const char *reason;
    double longest = 0.0, total = 0.0;
    long tick;

    spacecraft_start(&spacecraft, &controller_corrected);
    inputs.command_rotation[0] = 0.5 * 3.14159265358979 / 180.0;
    inputs.command_start_time = 5.0;
    controller = flexsat_prepare(&parameters, memory, sizeof memory, &reason);
    if (controller == NULL || flexsat_init(controller, inputs.command_rotation, inputs.command_start_time)) {
        fprintf(stderr, "example: %s\n", reason);
        return 1;
    }
    for (tick = 0; tick < ticks; tick++) {
        clock_t begun;
        double spent;

        wait_for_tick(tick);
        read_sensors(tick, &inputs);
        begun = clock();
        if (flexsat_step(controller, &inputs, &outputs) != FLEXSAT_OK) {
            fprintf(stderr, "example: step %ld: %s\n", tick, reason);
            return 1;
        }
        spent = (double)(clock() - begun) / CLOCKS_PER_SEC;
        longest = spent > longest ? spent : longest;
        total += spent;
        command_wheels(&outputs);
        if (tick % (ticks / 10 + 1) == 0) {
            printf("%8.3f s  turned %8.2f arcsec, %8.4f arcsec from the reference, torque of wheel 1 %8.4f N.m\n",
                   (double)tick * FLEXSAT_PERIOD, 4.0 * outputs.estimate[0] / ARCSECOND,
                   4.0 * (outputs.estimate[0] - outputs.reference[0]) / ARCSECOND, outputs.wheel_torque[0]);
        }
        if (tick == ticks / 2) { /* as a computer does that is switched over to its spare one */
            flexsat_save(controller, saved);
            if (flexsat_restore(controller, saved) != FLEXSAT_OK) {
                fprintf(stderr, "example: %s\n", reason);
                return 1;
            }
        }
    }
    printf("%ld steps, mean %.1f us, longest %.0f us\n", ticks, 1e6 * total / (double)ticks, 1e6 * longest);
    return 0;
}
