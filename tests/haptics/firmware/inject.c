/* inject KIND BEGIN MANY: the device by itself, a function of its hardware layer failing for MANY ticks from BEGIN on.
 * The layer below is hal_simulated.c, its functions renamed to sound_*. Prints events, and how it ended: code, power stage,
 * tick, signs of life, largest current. */
#include "delta_device.h"
#include "delta_hal.h"
#include "delta_run.h"
#include "simulated/device.h"
#include "simulated/hal_simulated.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int sound_hal_begin(void);
void sound_hal_wait(void);
double sound_hal_now(void);
int sound_hal_encoders(double angle[3], int fresh[3]);
void sound_hal_current(int joint, double ampere);
void sound_hal_enable(int on);
void sound_hal_damping(int joint, double share);

static const char *kind = "nothing";
static long long begin_at, many, ticks;
static int powered, fed;
static double ampere[3], given[3], largest;

static int failing(const char *name)
{
    return strcmp(kind, name) == 0 && ticks >= begin_at && ticks < begin_at + many;
}

int hal_begin(void) { return failing("begin") ? 1 : sound_hal_begin(); }

void hal_wait(void)
{
    ticks++;
    if (failing("wait repeats")) return;
    for (int k = 0; failing("wait late") && k < 30; k++) sound_hal_wait();
    sound_hal_wait();
}

double hal_now(void)
{
    static double last;
    double now = sound_hal_now();
    if (failing("now none")) return NAN;
    if (failing("now repeats")) return last;
    if (failing("now late")) return now - 0.01;
    if (failing("now ahead")) return now + 1.0;
    last = now;
    return now;
}

int hal_encoders(double angle[3], int fresh[3])
{
    static double last[3];
    int answer = sound_hal_encoders(angle, fresh);
    if (failing("encoders no bus")) return 1;
    if (failing("encoders not fresh")) fresh[1] = 0;
    if (failing("encoders none")) angle[1] = NAN;
    if (failing("encoders repeat")) memcpy(angle, last, sizeof last);
    if (failing("encoder repeats")) angle[1] = last[1];
    if (failing("encoders late")) fresh[0] = fresh[1] = fresh[2] = 0;
    memcpy(last, angle, sizeof last);
    return answer;
}

void hal_damping(int joint, double share) { sound_hal_damping(joint, share); }

void hal_current(int joint, double value)
{
    ampere[joint] = value;
    if (!failing("current lost")) given[joint] = value;
    sound_hal_current(joint, given[joint]);
}

void hal_enable(int on)
{
    powered = on;
    sound_hal_enable(on);
}

int hal_healthy(void) { return !failing("healthy"); }
int hal_stop_pressed(void) { return failing("stop"); }

/* The last call of a tick: the motors have their currents. */
void hal_watchdog(void)
{
    fed++;
    double most = 0.0;
    for (int j = 0; j < 3; j++) most = fabs(ampere[j]) > most ? fabs(ampere[j]) : most;
    if (!(most <= 1e3)) abort();
    if (most > largest) largest = most;
}

void hal_report(int event, int joint, double value, double bound)
{
    if (event != DELTA_EVENT_STEP) printf("event %d %d %.17g %.17g\n", event, joint, value, bound);
    else printf("step %d %lld\n", joint, ticks);
}

int main(int count, char **words)
{
    double seconds = 10.0;
    if (count > 3) {
        kind = words[1];
        begin_at = atoll(words[2]);
        many = atoll(words[3]);
    }
    delta_real laws[1][DELTA_LAW_COLUMNS] = { { 0 } }, *spring = laws[0];
    spring[DELTA_LAW_KIND] = DELTA_SPRING_DAMPER;
    spring[DELTA_LAW_GAIN] = 1;
    spring[DELTA_SPRING_DAMPER_STIFFNESS] = 400;
    spring[DELTA_SPRING_DAMPER_DAMPING] = 5;
    spring[DELTA_SPRING_DAMPER_POINT] = (delta_real)4e-3; /* pulls on for good */
    spring[DELTA_SPRING_DAMPER_POINT + 2] = (delta_real)DELTA_CENTRE_Z_M;
    device_begin(1);
    int ended = delta_run(laws[0], 1, (long long)(seconds / DELTA_PERIOD_S));
    printf("ended %d %d %lld %d %.17g\n", ended, powered, ticks, fed, largest);
    return 0;
}
