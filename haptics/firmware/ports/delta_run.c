#include "delta_run.h"
#include "delta_hal.h"
#include "delta_joints.h"

static int without(const delta_real torque[3])
{
    int none = 1;
    for (int k = 0; k < 3; k++) none = none && torque[k] >= 0 && torque[k] <= 0;
    return none;
}

static void tell_refusal(const delta_startup_memory *start)
{
    delta_refusal why = delta_startup_refusal(start);
    hal_report(DELTA_EVENT_REFUSED, why.joint, why.value, why.bound);
    hal_report(DELTA_EVENT_CODE, why.code, 0.0, 0.0);
}

int delta_run(const delta_real *laws, long rows, long long ticks)
{
    static delta_startup_memory start;
    static delta_memory memory;
    static delta_made made;
    delta_real raw[3], theta[3], wanted[3], torque[3] = { 0, 0, 0 }, offset[3] = { 0, 0, 0 };
    int fresh[3], told = -1, running = 0, ended = DELTA_RUN_DONE;
    if (hal_begin() != 0) return DELTA_RUN_NO_HARDWARE;
    delta_startup_begin(&start);
    delta_joints_write(torque, 0); /* before the power stage: none, whatever a drive was asked for last */
    hal_enable(1);
    for (long long k = 0; ticks == 0 || k < ticks; k++) {
        hal_wait();
        double now = delta_joints_read(raw, fresh);
        if (running) {
            for (int j = 0; j < 3; j++) raw[j] += offset[j];
            if (fresh[0] && fresh[1] && fresh[2]) delta_drawn(&made, raw, theta); /* else the last place stands, too */
            delta_signal(&memory, delta_joints_signals());
            delta_heard(&memory, now); /* the laws are the board's own; with a host: at each of its messages */
            long long bits = delta_tick(&memory, laws, rows, now, theta, raw, fresh, wanted);
            if (delta_state(&memory) == DELTA_STATE_FAULT && without(wanted)) {
                hal_report(DELTA_EVENT_FAULT, 3, (double)bits, 0.0);
                ended = DELTA_RUN_FAULT;
                break;
            }
            delta_turned(&made, wanted, torque);
        } else {
            delta_startup_signal(&start, delta_joints_signals());
            delta_shoulders(raw, theta);
            (void)delta_startup_tick(&start, now, theta, fresh, torque);
            int step = delta_startup_step(&start);
            if (step != told) hal_report(DELTA_EVENT_STEP, step, now, 0.0);
            told = step;
            if (step == DELTA_STARTUP_REFUSED && without(torque)) {
                tell_refusal(&start);
                ended = DELTA_RUN_REFUSED;
                break;
            }
            if (step == DELTA_STARTUP_READY) {
                delta_startup_offsets(&start, offset);
                delta_start(&memory);
                delta_enable(&memory);
                hal_report(DELTA_EVENT_READY, 3, now, 0.0);
                running = 1;
            }
        }
        delta_joints_write(torque, running && delta_touched(&memory));
        hal_watchdog();
    }
    for (int j = 0; j < 3; j++) hal_current(j, 0.0);
    hal_enable(0);
    return ended;
}
