/* alone [SECONDS [motor|encoder JOINT]]: start-up, then a spring that pulls into a wall, on the simulated device, as a
 * board would do it; with a wire turned round, to see how that is refused. Ends with the code of delta_run. */
#include "../delta_device.h"
#include "../delta_hal.h"
#include "../delta_run.h"
#include "../simulated/device.h"
#include "../simulated/hal_simulated.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void hal_report(int event, int joint, double value, double bound)
{
    printf("event %d %d %.9g %.9g\n", event, joint, value, bound);
}

int main(int many, char **words)
{
    double seconds = many > 1 ? atof(words[1]) : 12.0, angle[3];
    if (many > 3) {
        int joint = atoi(words[3]);
        int *wire = strcmp(words[2], "motor") == 0 ? hal_wired.motor : hal_wired.encoder;
        if (joint >= 0 && joint < 3) wire[joint] = -1;
    }
    delta_real laws[2][DELTA_LAW_COLUMNS] = { { 0 }, { 0 } }, *spring = laws[0], *wall = laws[1];
    spring[DELTA_LAW_KIND] = DELTA_SPRING_DAMPER;
    spring[DELTA_LAW_GAIN] = 1;
    spring[DELTA_SPRING_DAMPER_STIFFNESS] = 400;
    spring[DELTA_SPRING_DAMPER_DAMPING] = 5;
    spring[DELTA_SPRING_DAMPER_POINT] = (delta_real)DELTA_CENTRE_X_M;
    spring[DELTA_SPRING_DAMPER_POINT + 2] = (delta_real)DELTA_CENTRE_Z_M;
    wall[DELTA_LAW_KIND] = DELTA_VIRTUAL_WALL;
    wall[DELTA_LAW_GAIN] = 1;
    wall[DELTA_VIRTUAL_WALL_STIFFNESS] = 2000;
    wall[DELTA_VIRTUAL_WALL_NORMAL + 2] = 1;
    wall[DELTA_VIRTUAL_WALL_POINT + 2] = (delta_real)(DELTA_CENTRE_Z_M + 2e-3);
    wall[DELTA_VIRTUAL_WALL_BLEND] = (delta_real)1e-3;
    device_begin(1);
    int ended = delta_run(laws[0], 2, (long long)(seconds / DELTA_PERIOD_S));
    device_angles(angle);
    printf("ended %d at %.6f %.6f %.6f rad, %s a wall\n", ended, angle[0], angle[1], angle[2],
           hal_wired.touched ? "damped as at" : "without");
    return ended;
}
