/* Datagrams on the serial line, framed by SLIP (RFC 1055): 2 Mbaud, 8 bits, no parity, through the board's ST-LINK. */
#include "../delta_hal.h"
#include "board.h"
#include "registers.h"
#include <string.h>

enum { END = 0xC0, ESCAPE = 0xDB, ESCAPED_END = 0xDC, ESCAPED_ESCAPE = 0xDD };
enum { RING = 512, LONGEST = 64 }; /* bytes; the ring's size is a power of two */

typedef struct {
    volatile unsigned in, out; /* of them, so far; each has one writer */
    unsigned char data[RING];
} ring;

static ring coming, going;

static int put(ring *to, unsigned char byte)
{
    if (to->in - to->out >= RING) return 1;
    to->data[to->in % RING] = byte;
    to->in++;
    return 0;
}

static int take(ring *from, unsigned char *byte)
{
    if (from->in == from->out) return 1;
    *byte = from->data[from->out % RING];
    from->out++;
    return 0;
}

void board_serial(void)
{
    uint32_t flags = reg_get(LPUART1_ISR);
    unsigned char byte;
    if (flags & 1u << 3) {
        board_now.overruns++;
        reg_put(LPUART1_ICR, 1u << 3);
    }
    if ((flags & 1u << 5) && put(&coming, (unsigned char)reg_get(LPUART1_RDR)) != 0) board_now.overruns++;
    if ((flags & 1u << 7) && (reg_get(LPUART1_CR1) & 1u << 7)) {
        if (take(&going, &byte) == 0) reg_put(LPUART1_TDR, byte);
        else reg_put(LPUART1_CR1, reg_get(LPUART1_CR1) & ~(1u << 7));
    }
}

void board_send(const void *data, size_t bytes)
{
    const unsigned char *from = data;
    if (RING - (going.in - going.out) < 2 * bytes + 2) { /* whole or not at all */
        board_now.overruns++;
        return;
    }
    (void)put(&going, END);
    for (size_t k = 0; k < bytes; k++) {
        int special = from[k] == END || from[k] == ESCAPE;
        if (special) (void)put(&going, ESCAPE);
        (void)put(&going, special ? (from[k] == END ? ESCAPED_END : ESCAPED_ESCAPE) : from[k]);
    }
    (void)put(&going, END);
    reg_set(LPUART1_CR1, 1u << 7);
}

size_t hal_receive(unsigned char *data, size_t most, unsigned char sender[32])
{
    static unsigned char frame[LONGEST];
    static size_t length;
    static int escaped, spoilt;
    unsigned char byte;
    memset(sender, 0, 32); /* one host at the other end of a cable */
    while (take(&coming, &byte) == 0) {
        if (byte == END) {
            size_t whole = spoilt || escaped || length > most ? 0 : length;
            memcpy(data, frame, whole);
            length = 0;
            escaped = spoilt = 0;
            if (whole > 0) return whole;
        } else if (byte == ESCAPE) {
            escaped = 1;
        } else {
            if (escaped) byte = byte == ESCAPED_END ? END : ESCAPE;
            escaped = 0;
            if (length < LONGEST) frame[length++] = byte;
            else spoilt = 1;
        }
    }
    return 0;
}

void hal_send(const unsigned char *data, size_t bytes, const unsigned char to[32])
{
    (void)to;
    board_send(data, bytes);
}

void hal_report(int event, int joint, double value, double bound)
{
    struct {
        int32_t event, joint;
        double value, bound;
    } record = { event, joint, value, bound };
    board_send(&record, sizeof record);
}
