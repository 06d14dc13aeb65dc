#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "fast-math drops NaN, by which wrong readings and commands are known"
#endif
#include "delta_joints.h"
#include "delta_device.h"
#include "delta_hal.h"
#include <math.h>

double delta_joints_read(delta_real theta[3], int fresh[3])
{
    double now = hal_now(), angle[3] = { NAN, NAN, NAN };
    int found[3] = { 0, 0, 0 }, answered = hal_encoders(angle, found) == 0;
    for (int j = 0; j < 3; j++) {
        fresh[j] = answered && found[j] == 1;
        theta[j] = fresh[j] ? (delta_real)angle[j] : (delta_real)NAN;
    }
    return now;
}

void delta_joints_write(const delta_real torque[3], int touched)
{
    for (int j = 0; j < 3; j++) {
        hal_damping(j, touched ? DELTA_CONTACT_DAMPING : DELTA_DAMPING);
        hal_current(j, DELTA_AMPERE_PER_N_M * (double)torque[j]);
    }
}

long long delta_joints_signals(void)
{
    return (hal_stop_pressed() ? DELTA_EMERGENCY_STOP : 0LL) | (hal_healthy() ? 0LL : DELTA_WATCHDOG);
}
