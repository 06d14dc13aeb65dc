/* A board in a library: its hardware is what a test sets and looks at. */
#include "delta_board.h"
#include "delta_hal.h"
#include "delta_joints.h"
#include <string.h>

static delta_board board;
double board_now, board_angle[3], board_torque[3], board_damping;
int board_fresh[3], board_stopped, board_healthy = 1;

int hal_begin(void) { return 0; }
void hal_wait(void) {}
double hal_now(void) { return board_now; }
int hal_encoders(double angle[3], int fresh[3])
{
    memcpy(angle, board_angle, sizeof board_angle);
    memcpy(fresh, board_fresh, sizeof board_fresh);
    return 0;
}
void hal_damping(int joint, double share) { board_damping = joint == 0 ? share : board_damping; }
void hal_current(int joint, double ampere) { board_torque[joint] = ampere; }
void hal_enable(int on) { (void)on; }
int hal_healthy(void) { return board_healthy; }
int hal_stop_pressed(void) { return board_stopped; }
void hal_watchdog(void) {}

void board_begin(double period, double limit, uint32_t counts) { delta_board_begin(&board, period, limit, counts); }
size_t board_received(const unsigned char *data, size_t bytes, const unsigned char *peer, unsigned char *reply)
{
    return delta_board_received(&board, data, bytes, peer, reply);
}
size_t board_tick(unsigned char *state) { return delta_board_tick(&board, state); }
int board_figure(int which)
{
    int figures[] = { board.tripped, board.connected, (int)board.served, (int)board.late, (int)board.sessions };
    return figures[which];
}
