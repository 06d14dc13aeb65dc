/* A simulated MT6835 by the lines of its bus, as its data sheet (rev. 1.3) has it; nothing of the driver is used. */
#ifndef CHIP_H
#define CHIP_H

#include <stdint.h>

typedef struct {
    uint32_t angle;         /* 21 bits, of the magnet now */
    unsigned status;        /* bits of STATUS */
    uint32_t flips;         /* bits of a frame that are turned round on the wire, the CRC's eight the lowest */
    int line;               /* -1: the chip drives MISO; 0 or 1: the line is held there */
    unsigned char registers[0x20];
    /* of the bus */
    uint32_t latched;
    unsigned latched_status;
    int unread;             /* latched, and not yet read out to 0x006 */
    int bytes;              /* since CSN fell */
    unsigned command, address;
} chip;

void chip_reset(chip *one);
void chip_select(chip *one, int low);
unsigned char chip_exchange(chip *one, unsigned char out);

#endif
