/* A device by itself: start-up, then force laws of the board's own, until something stops it. */
#ifndef DELTA_RUN_H
#define DELTA_RUN_H

#include "delta_controller.h"

/* Events of hal_report. */
enum {
    DELTA_EVENT_STEP = 1, /* the start-up has come to a step: joint is its number */
    DELTA_EVENT_READY,    /* the laws act from now on */
    DELTA_EVENT_REFUSED,  /* the start-up has ended: joint, value and bound of delta_refusal; then the code follows: */
    DELTA_EVENT_CODE,     /* joint is the code of the refusal */
    DELTA_EVENT_FAULT     /* the supervisor has stopped: value is its bits */
};

/* How it ended. */
enum { DELTA_RUN_DONE, DELTA_RUN_NO_HARDWARE, DELTA_RUN_REFUSED, DELTA_RUN_FAULT };

/* Runs for so many periods; 0 for ever. The power stage is off when it returns. */
int delta_run(const delta_real *laws, long rows, long long ticks);

#endif
