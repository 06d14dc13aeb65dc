/* The device by itself: start-up, then a spring at the cube's centre. What happens comes as records of 24 bytes. */
#include "../delta_device.h"
#include "../delta_run.h"
#include "board.h"

int main(void)
{
    static delta_real spring[DELTA_LAW_COLUMNS];
    spring[DELTA_LAW_KIND] = DELTA_SPRING_DAMPER;
    spring[DELTA_LAW_GAIN] = 1;
    spring[DELTA_SPRING_DAMPER_STIFFNESS] = 400;
    spring[DELTA_SPRING_DAMPER_DAMPING] = 5;
    spring[DELTA_SPRING_DAMPER_POINT] = (delta_real)DELTA_CENTRE_X_M;
    spring[DELTA_SPRING_DAMPER_POINT + 2] = (delta_real)DELTA_CENTRE_Z_M;
    return delta_run(spring, 1, 0);
}
