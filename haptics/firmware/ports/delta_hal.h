/* The hardware layer: the functions that a port writes for its board; PORTING.md says how. Angles are those of the
 * joints in rad, level 0 and upwards positive; all is called from one context, once a period, and none of it waits but
 * hal_wait. */
#ifndef DELTA_HAL_H
#define DELTA_HAL_H

#include <stddef.h>

/* Clocks, encoders, drives and timer set up, power stage off. 0 if all of it answers. */
int hal_begin(void);
/* Waits for the timer's next period. */
void hal_wait(void);
/* Time in s of a counter of 64 bits that only grows; of the reading that follows. */
double hal_now(void);
/* Angles of all joints, of one moment. `fresh` is 1 for a joint whose reading was taken since the last call and passed its
 * own check (CRC or parity, warning bits), else 0, and its angle then does not count. 0 if the bus answered; else none is
 * fresh. */
int hal_encoders(double angle[3], int fresh[3]);
/* Physical damping of a motor by its drive from the next current on, as a share of its short circuit, k_t^2 / R. */
void hal_damping(int joint, double share);
/* Current of a motor, A; positive lifts the arm. Takes effect at once: by half of the period. */
void hal_current(int joint, double ampere);
/* Power stage of all drives; off lets the motors turn freely. */
void hal_enable(int on);
/* 0 once a drive has cut its current by itself (supply, heat, its own watchdog), or its measured current is not the one
 * that was commanded: nothing else sees that. */
int hal_healthy(void);
/* Whether the emergency stop is pressed. It must cut the power stage by wire, too. */
int hal_stop_pressed(void);
/* A sign of life for the hardware's watchdog, which cuts the power stage within some periods without one. */
void hal_watchdog(void);
/* Something that a person should know: delta_run.h has the events. */
void hal_report(int event, int joint, double value, double bound);
/* Only for a board on a link (delta_board.c): the next datagram and its sender, 0 bytes if there is none; and one out. */
size_t hal_receive(unsigned char *data, size_t most, unsigned char sender[32]);
void hal_send(const unsigned char *data, size_t bytes, const unsigned char to[32]);

#endif
