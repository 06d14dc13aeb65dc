/* The simulated device in place of encoders and drives: what a process sets of it. */
#ifndef HAL_SIMULATED_H
#define HAL_SIMULATED_H

typedef struct {
    int motor[3], encoder[3]; /* 1 or -1: signs of the wires */
    int stopped;              /* whether the emergency stop is pressed */
    int touched;              /* whether the drives damp as they do at a wall */
    int exact;                /* whether readings have counts alone, and no noise */
} hal_wiring;

extern hal_wiring hal_wired;

#endif
