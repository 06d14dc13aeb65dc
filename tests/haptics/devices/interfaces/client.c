/* A program on the library: a spring to a point, all it is told printed; or one call and its status. */
#define _XOPEN_SOURCE 600
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>

#include "delta_device.h"
#include "delta_machine.h"

static void print(const char *name, const double v[3]) { printf(" %s %.17g %.17g %.17g", name, v[0], v[1], v[2]); }

static volatile sig_atomic_t rung;

static void ring(int number) { rung = number; }

/* A signal every half a millisecond, as profilers and timers send them. */
static void set_alarm(void)
{
    struct itimerval each = {{0, 500}, {0, 500}};
    struct sigaction act;
    memset(&act, 0, sizeof act);
    act.sa_handler = ring;
    sigaction(SIGALRM, &act, NULL);
    setitimer(ITIMER_REAL, &each, NULL);
}

int main(int argc, char **argv)
{
    delta_config config = DELTA_MACHINE;
    int status = DELTA_OK, ticks = argc > 2 ? atoi(argv[2]) : 0;
    double target[3] = {0.004, -0.003, DELTA_CENTRE_Z + 0.002}, p[3], v[3], a[3], t[3], force[3];
    if (getenv("TIMEOUT") != NULL)
        config.timeout = atof(getenv("TIMEOUT"));
    if (getenv("ALARM") != NULL)
        set_alarm();
    if (argc > 3)
        config.ramp = atof(argv[3]);
    delta_device *device = delta_open(&config, argc > 4 ? argv[4] : "127.0.0.1", (uint16_t)atoi(argv[1]), &status);
    printf("open %d %s\n", status, delta_text(status));
    for (int n = 0; device != NULL && n < ticks; n++) {
        int known = delta_position(device, p);
        if (known != DELTA_OK || delta_velocity(device, v) != DELTA_OK)
            memset(p, 0, sizeof p), memset(v, 0, sizeof v);
        delta_angles(device, a);
        for (int k = 0; k < 3; k++)
            force[k] = 300.0 * (target[k] - p[k]);
        double time = delta_time(device);
        unsigned flags = delta_flags(device);
        if (getenv("RESET_AT") != NULL && n == atoi(getenv("RESET_AT")))
            delta_reset(device);
        status = delta_set_force(device, force);
        delta_torques(device, t);
        printf("tick %.9f %d %u %d", time, known, flags, status);
        print("a", a), print("p", p), print("v", v), print("t", t);
        printf("\n");
        if (status == DELTA_LOST)
            break;
    }
    printf("null %d %d %u\n", delta_position(NULL, p), delta_set_force(NULL, p), delta_flags(NULL));
    if (device != NULL) {
        const double wrong[3] = {0.0, 0.0 / (double)(argc > 100), 0.0};
        printf("nan %d period %.9g\n", delta_set_force(device, wrong), delta_period(device));
    }
    return delta_close(device);
}
