/* Start-up and a spring on a bare core, the simulated device in place of drives: alone.out gets the events, as records
 * of two 32-bit numbers and two doubles; the exit code is that of delta_run. */
#include "../delta_device.h"
#include "../delta_hal.h"
#include "../delta_run.h"
#include "../simulated/device.h"
#include "semihosting.h"
#include <stdint.h>

static int told = -1;

void hal_report(int event, int joint, double value, double bound)
{
    struct {
        int32_t event, joint;
        double value, bound;
    } record = { event, joint, value, bound };
    (void)semihosting_write(told, &record, sizeof record);
}

int main(void)
{
    static delta_real spring[DELTA_LAW_COLUMNS];
    spring[DELTA_LAW_KIND] = DELTA_SPRING_DAMPER;
    spring[DELTA_LAW_GAIN] = 1;
    spring[DELTA_SPRING_DAMPER_STIFFNESS] = 400;
    spring[DELTA_SPRING_DAMPER_DAMPING] = 5;
    spring[DELTA_SPRING_DAMPER_POINT] = (delta_real)DELTA_CENTRE_X_M;
    spring[DELTA_SPRING_DAMPER_POINT + 2] = (delta_real)DELTA_CENTRE_Z_M;
    told = semihosting_open("alone.out", SEMIHOSTING_WRITE);
    if (told < 0) return 4;
    device_begin(1);
    int ended = delta_run(spring, 1, (long long)(9.0 / DELTA_PERIOD_S));
    semihosting_close(told);
    return ended;
}
