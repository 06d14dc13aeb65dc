/* The board of the socket protocol on the serial line: a host computes the torques. Firmware of 1 kHz or less: two
 * packets a tick are 1.2 Mbaud at 1 kHz. */
#include "../delta_board.h"
#include "../delta_controller.h"
#include "../delta_device.h"
#include "../delta_hal.h"
#include "board.h"

enum { AT_ONCE = 4 };

int main(void)
{
    static delta_board board;
    unsigned char data[DELTA_PACKET_MOST], reply[DELTA_PACKET_MOST], sender[DELTA_PEER];
    int on = 0;
    if (hal_begin() != 0) return 1;
    delta_board_begin(&board, DELTA_PERIOD_S, (double)DELTA_TORQUE_N_M, DELTA_COUNTS_PER_TURN);
    for (;;) {
        for (int k = 0; k < AT_ONCE; k++) {
            size_t bytes = hal_receive(data, sizeof data, sender);
            if (bytes == 0) break;
            size_t answer = delta_board_received(&board, data, bytes, sender, reply);
            if (answer > 0) hal_send(reply, answer, sender);
        }
        int wanted = board.connected && !board.tripped && !hal_stop_pressed();
        if (wanted != on) hal_enable(wanted);
        on = wanted;
        size_t state = delta_board_tick(&board, reply);
        if (state > 0) hal_send(reply, state, board.peer);
    }
}
