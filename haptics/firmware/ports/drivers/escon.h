/* maxon ESCON Module 50/5 (438725), a servo drive for a brushed motor, as three current controllers by wire.
 *
 * Source: ESCON Module 50/5 Hardware Reference, rel9051, August 2021: 2.1 (10 to 50 V, 5 A, 15 A for 20 s; current
 * controller at 53.6 kHz; analogue inputs -10 to 10 V, 12 bits, differential), 3.3.4.1 and 3.3.4.3 (digital inputs:
 * logic 1 above 2.4 V, they switch within 8 ms; outputs open, up to 36 V and 500 mA).
 *
 * The set value is a voltage, not a duty cycle: a PWM input takes at most 5 kHz, there at 2.5 %, and a reading a period
 * late, where the walls count on half a tick. Three things follow from the sheet:
 * - force that is taken away by the enable input goes within 8 ms; by the set value at once: both are used;
 * - one step of the drive's converter is 4.88 mV;
 * - no output says what current flows: a drive that does not follow is found by its ready line and the supervisor.
 *
 * Settings of ESCON Studio for each drive: mode current controller (closed loop); enable by digital input 2, high
 * active; set value by analogue input 1, 0 A at 0 V, ESCON_LIMIT_A at ESCON_LIMIT_A x ESCON_VOLT_PER_A; no offset; no
 * current ramp; current limit ESCON_LIMIT_A; digital output 3 "ready", low active, so that a broken wire or a drive
 * without supply reads as not ready through the board's pull-up. */
#ifndef DELTA_ESCON_H
#define DELTA_ESCON_H

#ifndef ESCON_LIMIT_A
#define ESCON_LIMIT_A 7.5
#endif
#ifndef ESCON_VOLT_PER_A
#define ESCON_VOLT_PER_A 0.22 /* 1.65 V at 7.5 A: what a converter of 3.3 V gives about its middle */
#endif
enum { ESCON_MOST_NOT_READY = 2 }; /* readings of the ready line in a row that are put down to noise */

typedef struct {
    int enabled;      /* whether the enable input is high */
    int not_ready[3]; /* readings in a row at which a drive was not ready; stays at ESCON_MOST_NOT_READY + 1 */
} escon;

/* Set values 0, enable low. */
void escon_begin(escon *drives);
/* Enable input of all drives; off takes the set values to 0 first, and forgets what was not ready. */
void escon_enable(escon *drives, int on);
/* Current of a motor, A: 0 unless enabled and all drives are ready, or if it is no number; within the limit. */
void escon_current(escon *drives, int joint, double ampere);
/* Reads the ready lines, once a period; 1 while all drives have been ready. A drive that was not stays out, with all
 * set values 0 and enable low, until escon_enable is called again. */
int escon_healthy(escon *drives);

#endif
