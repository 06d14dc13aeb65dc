#include "chip.h"
#include <string.h>

void chip_reset(chip *one)
{
    memset(one, 0, sizeof *one);
    one->line = -1;
    one->registers[0x011] = 0xA5; /* "MagnTek use only" in bits 3 to 7, BW = 5 */
}

void chip_select(chip *one, int low)
{
    if (!low) return;
    one->bytes = 0;
    if (!one->unread) { /* latches at the falling edge, unless the last latch was not read out */
        one->latched = one->angle & 0x1FFFFFu;
        one->latched_status = one->status & 7u;
        one->unread = 1;
    }
}

/* Remainder of the 24 bits times x^8 by the polynomial, bit by bit on one long number. */
static unsigned remainder_of(uint32_t data)
{
    uint64_t rest = (uint64_t)data << 8;
    for (int bit = 31; bit >= 8; bit--) {
        if (rest >> bit & 1u) rest ^= (uint64_t)0x107u << (bit - 8);
    }
    return (unsigned)rest;
}

static unsigned char held(chip *one, unsigned address)
{
    uint32_t word = one->latched << 3 | one->latched_status;
    switch (address) {
    case 0x003: return (unsigned char)(word >> 16 ^ one->flips >> 24);
    case 0x004: return (unsigned char)(word >> 8 ^ one->flips >> 16);
    case 0x005: return (unsigned char)(word ^ one->flips >> 8);
    case 0x006:
        one->unread = 0;
        return (unsigned char)(remainder_of(word) ^ one->flips);
    default: return address < sizeof one->registers ? one->registers[address] : 0;
    }
}

unsigned char chip_exchange(chip *one, unsigned char out)
{
    unsigned char in = 0xFF; /* Hi-Z, pulled up */
    int at = one->bytes++;
    if (at == 0) {
        one->command = out >> 4;
        one->address = (unsigned)(out & 0xFu) << 8;
    } else if (at == 1) {
        one->address |= out;
    } else if (one->command == 0xA) {
        in = held(one, one->address++);
    } else if (one->command == 0x3 && at == 2) {
        in = held(one, one->address);
    } else if (one->command == 0x6 && at == 2 && one->address < sizeof one->registers) {
        one->registers[one->address] = out;
    }
    return one->line < 0 ? in : (unsigned char)(one->line ? 0xFF : 0x00);
}
