/* MagnTek MT6835, a magnetic angle encoder of 21 bits, by SPI.
 *
 * Source: MT6835 data sheet, rev. 1.3, December 2022: commands 7.6.3, burst read of the angle 7.6.9, registers 10, status
 * and CRC 7.6.8. Three things that it says and that are easily missed:
 * - the angle has 21 bits in three registers; the first two alone are 16 bits, 32 times as coarse;
 * - the angle is latched as CSN falls, and not again until all of 0x003 to 0x006 have been read: after a reading that
 *   was broken off the next one is the old angle, with a good CRC;
 * - a frame of zeros has a good CRC: a data line that is held low reads as the angle 0. */
#ifndef DELTA_MT6835_H
#define DELTA_MT6835_H

#include <stdint.h>

enum { MT6835_COUNTS = 2097152 };
/* Status bits of a reading. */
enum { MT6835_OVERSPEED = 1, MT6835_WEAK_FIELD = 2, MT6835_UNDERVOLTAGE = 4 };
/* Readings in a row that may be the same to the last bit; one more is not fresh. The chip's noise is 0.0015 deg rms with
 * BW = 5 and half of that with BW = 3, 4.4 counts. The supervisor has a limit of its own, which is lower and follows from
 * the encoder's row: this one is for a reader without it. */
enum { MT6835_SAME = 24 };

typedef enum {
    MT6835_FRESH,
    MT6835_NO_TRANSFER, /* the bus did not exchange all bytes */
    MT6835_DEAD_LINE,   /* all bits the same: no chip, no supply, a broken or shorted wire */
    MT6835_WRONG_CRC,
    MT6835_WARNING, /* a status bit is set */
    MT6835_OLD,     /* latched before: the first reading, and that after one that was broken off */
    MT6835_STUCK    /* the same value too often */
} mt6835_finding;

typedef struct {
    uint32_t count;   /* of the last frame with a good CRC, 0 to MT6835_COUNTS - 1 */
    unsigned status;  /* its status bits */
    int same;         /* how often it has repeated */
    int broken;       /* 1 if the chip holds a latch that was not read out */
    uint32_t found[7]; /* how often each mt6835_finding was made */
} mt6835;

/* Sets the bandwidth register, 0x011 bits 0 to 2, until the supply goes; the other bits stay. 0 if it reads back. */
int mt6835_begin(mt6835 *chip, int joint, unsigned bandwidth);
/* Reads the angle; `count` and `status` are of this moment if it is MT6835_FRESH. */
mt6835_finding mt6835_read(mt6835 *chip, int joint);
/* Angle of a count from the chip's zero, rad, above -pi and at most pi. */
double mt6835_rad(uint32_t count);

#endif
