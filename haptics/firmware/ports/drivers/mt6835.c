#include "mt6835.h"
#include "wires.h"
#include <string.h>

enum { READ_REGISTER = 0x3, WRITE_REGISTER = 0x6, BURST_ANGLE = 0xA };
enum { ANGLE = 0x003, BANDWIDTH = 0x011, BANDWIDTH_BITS = 0x7 };
enum { HEAD = 2, FRAME = 4 }; /* bytes: command and address; three registers of angle and status, and the CRC */
#define RAD_PER_COUNT (6.283185307179586476925286766559 / 2097152.0)

static void head(unsigned char *out, unsigned command, unsigned address)
{
    out[0] = (unsigned char)(command << 4 | address >> 8);
    out[1] = (unsigned char)(address & 0xFFu);
}

/* x^8 + x^2 + x + 1, from 0, the most significant bit first. */
static unsigned crc(const unsigned char *data, int bytes)
{
    unsigned value = 0;
    for (int k = 0; k < bytes; k++) {
        value ^= data[k];
        for (int bit = 0; bit < 8; bit++) value = (value << 1 ^ (value & 0x80u ? 0x07u : 0u)) & 0xFFu;
    }
    return value;
}

static int one_register(int joint, unsigned command, unsigned address, unsigned char *value)
{
    unsigned char out[HEAD + 1], in[HEAD + 1];
    head(out, command, address);
    out[HEAD] = *value;
    if (wire_encoder(joint, out, in, sizeof out) != 0) return 1;
    *value = in[HEAD];
    return 0;
}

int mt6835_begin(mt6835 *chip, int joint, unsigned bandwidth)
{
    unsigned char before = 0, wanted, after = 0;
    memset(chip, 0, sizeof *chip);
    chip->broken = 1; /* CSN falls for each register, and the angle that is latched then is not read out */
    if (one_register(joint, READ_REGISTER, BANDWIDTH, &before) != 0) return 1;
    wanted = (unsigned char)((before & ~(unsigned)BANDWIDTH_BITS) | (bandwidth & BANDWIDTH_BITS));
    after = wanted;
    if (one_register(joint, WRITE_REGISTER, BANDWIDTH, &after) != 0) return 1;
    after = 0;
    if (one_register(joint, READ_REGISTER, BANDWIDTH, &after) != 0) return 1;
    return after != wanted;
}

static mt6835_finding finding(mt6835 *chip, int joint)
{
    unsigned char out[HEAD + FRAME] = { 0 }, in[HEAD + FRAME];
    const unsigned char *frame = in + HEAD;
    head(out, BURST_ANGLE, ANGLE);
    memset(in, 0, sizeof in);
    if (wire_encoder(joint, out, in, sizeof out) != 0) {
        chip->broken = 1;
        return MT6835_NO_TRANSFER;
    }
    int old = chip->broken;
    chip->broken = 0;
    int zeros = 1, ones = 1;
    for (int k = 0; k < FRAME; k++) {
        zeros = zeros && frame[k] == 0x00;
        ones = ones && frame[k] == 0xFF;
    }
    if (zeros || ones) return MT6835_DEAD_LINE;
    if (crc(frame, FRAME - 1) != frame[FRAME - 1]) return MT6835_WRONG_CRC;
    uint32_t count = (uint32_t)frame[0] << 13 | (uint32_t)frame[1] << 5 | (uint32_t)frame[2] >> 3;
    chip->same = count == chip->count ? chip->same + (chip->same <= MT6835_SAME) : 0;
    chip->count = count;
    chip->status = frame[2] & (MT6835_OVERSPEED | MT6835_WEAK_FIELD | MT6835_UNDERVOLTAGE);
    if (chip->status != 0) return MT6835_WARNING;
    if (old) return MT6835_OLD;
    return chip->same > MT6835_SAME ? MT6835_STUCK : MT6835_FRESH;
}

mt6835_finding mt6835_read(mt6835 *chip, int joint)
{
    mt6835_finding found = finding(chip, joint);
    chip->found[found]++;
    return found;
}

double mt6835_rad(uint32_t count)
{
    int32_t from_zero = (int32_t)count - (count > MT6835_COUNTS / 2 ? MT6835_COUNTS : 0);
    return from_zero * RAD_PER_COUNT;
}
