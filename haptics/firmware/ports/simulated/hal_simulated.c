#include "hal_simulated.h"
#include "../delta_controller.h"
#include "../delta_device.h"
#include "../delta_hal.h"
#include "device.h"
#include <math.h>
#include <stdint.h>

hal_wiring hal_wired = { { 1, 1, 1 }, { 1, 1, 1 }, 0, 0, 0 };
static int begun, powered;
static long long ticks;
static double torque[3], current[3], angle[3];

int hal_begin(void)
{
    ticks = 0;
    begun = powered = hal_wired.touched = 0;
    return 0;
}

void hal_wait(void)
{
    if (begun) {
        for (int j = 0; j < 3; j++) torque[j] = powered ? hal_wired.motor[j] * current[j] / DELTA_AMPERE_PER_N_M : 0.0;
        device_step(torque, powered && hal_wired.touched, DELTA_PERIOD_S);
        ticks++;
    }
    begun = 1;
    device_angles(angle);
}

double hal_now(void) { return (double)ticks * DELTA_PERIOD_S; }

/* A number of mean 0 and variance 1, normal within what twelve equal ones add up to. */
static double normal(void)
{
    static uint32_t drawn = 1u;
    double sum = -6.0;
    for (int k = 0; k < 12; k++) {
        drawn = drawn * 1664525u + 1013904223u;
        sum += drawn / 4294967296.0;
    }
    return sum;
}

int hal_encoders(double found[3], int fresh[3])
{
    static double noise[3];
    for (int j = 0; j < 3; j++) {
        noise[j] = DELTA_NOISE_KEPT * noise[j] + sqrt(1.0 - DELTA_NOISE_KEPT * DELTA_NOISE_KEPT) * normal();
        double seen = angle[j] + (hal_wired.exact ? 0.0 : DELTA_NOISE_RAD * noise[j]);
        found[j] = hal_wired.encoder[j] * nearbyint(seen / DELTA_COUNT_RAD) * DELTA_COUNT_RAD;
        fresh[j] = isfinite(found[j]) != 0;
    }
    return 0;
}

void hal_damping(int joint, double share)
{
    if (joint == 0) hal_wired.touched = share > DELTA_DAMPING; /* all joints have the same */
}

void hal_current(int joint, double ampere) { current[joint] = ampere; }
void hal_enable(int on) { powered = on; }
int hal_healthy(void) { return 1; }
int hal_stop_pressed(void) { return hal_wired.stopped; }
void hal_watchdog(void) {}
