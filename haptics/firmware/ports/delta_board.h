/* The board's side of the socket protocol, version 1 (haptics/devices/PROTOCOL.md): a host computes the torques. */
#ifndef DELTA_BOARD_H
#define DELTA_BOARD_H

#include <stddef.h>
#include <stdint.h>

enum { DELTA_PACKET_MOST = 64, DELTA_PEER = 32 };

typedef struct {
    unsigned char peer[DELTA_PEER];
    int connected, answered, tripped, held, touched;
    uint32_t session, sequence, issued, heard, counts_per_turn;
    double period, torque_limit, watchdog, silent, time, passed;
    double torque[3];
    unsigned long dropped, late, sessions, served;
} delta_board;

void delta_board_begin(delta_board *board, double period, double torque_limit, uint32_t counts_per_turn);
/* Takes a datagram; the length of the reply for its sender, 0 for none. */
size_t delta_board_received(delta_board *board, const unsigned char *data, size_t bytes,
                            const unsigned char peer[DELTA_PEER], unsigned char reply[DELTA_PACKET_MOST]);
/* One period: watchdog, torques out, reading in; the length of the STATE for the host, 0 without one. */
size_t delta_board_tick(delta_board *board, unsigned char state[DELTA_PACKET_MOST]);
/* Ends the session; the length of the BYE. */
size_t delta_board_farewell(delta_board *board, unsigned char bye[DELTA_PACKET_MOST]);

#endif
