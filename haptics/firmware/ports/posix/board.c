/* board [PORT [paced|exact]]: a board of the socket protocol on loopback, the simulated device behind it; one session.
 * Paced it keeps to the clock; exact its readings have no noise. */
#define _POSIX_C_SOURCE 200809L
#include "../delta_board.h"
#include "../delta_controller.h"
#include "../delta_device.h"
#include "../delta_hal.h"
#include "../simulated/device.h"
#include "../simulated/hal_simulated.h"
#include "link.h"
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifndef IDLE_MS
#define IDLE_MS 20000 /* without a session after which it ends */
#endif
enum { PATIENCE_MS = 50, AT_ONCE = 16 }; /* datagrams of a tick: a flood must not hold it up */
static volatile sig_atomic_t stopped;

/* SIGUSR1 presses the emergency stop, SIGUSR2 releases it. */
static void press(int signal) { stopped = signal == SIGUSR1; }

void hal_report(int event, int joint, double value, double bound)
{
    fprintf(stderr, "event %d %d %.9g %.9g\n", event, joint, value, bound);
}

/* Sleeps until a period after the last one. */
static void pace(struct timespec *due)
{
    due->tv_nsec += (long)(DELTA_PERIOD_S * 1e9);
    if (due->tv_nsec >= 1000000000L) {
        due->tv_nsec -= 1000000000L;
        due->tv_sec++;
    }
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, due, NULL) == EINTR) {}
}

/* Time since then, ms. */
static long since(const struct timespec *then)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (long)(now.tv_sec - then->tv_sec) * 1000L + (now.tv_nsec - then->tv_nsec) / 1000000L;
}

int main(int many, char **words)
{
    static delta_board board;
    unsigned char data[2048], reply[DELTA_PACKET_MOST], sender[DELTA_PEER];
    int port = link_listen(many > 1 ? atoi(words[1]) : 0);
    if (port < 0) {
        fprintf(stderr, "the port cannot be had\n");
        return 2;
    }
    struct timespec due, last;
    int paced = many > 2 && strcmp(words[2], "paced") == 0;
    hal_wired.exact = many > 2 && strcmp(words[2], "exact") == 0;
    struct sigaction pressed; /* by `signal` a second press would end the process */
    memset(&pressed, 0, sizeof pressed);
    pressed.sa_handler = press;
    sigaction(SIGUSR1, &pressed, NULL);
    sigaction(SIGUSR2, &pressed, NULL);
    device_begin(0);
    if (hal_begin() != 0) return 2;
    hal_enable(1);
    delta_board_begin(&board, DELTA_PERIOD_S, (double)DELTA_TORQUE_N_M, DELTA_COUNTS_PER_TURN);
    printf("listening on 127.0.0.1 %d\n", port);
    fflush(stdout);
    int served = 0;
    clock_gettime(CLOCK_MONOTONIC, &due);
    last = due;
    while (!(served && !board.connected)) {
        long left = PATIENCE_MS - since(&last);
        long idle = IDLE_MS - since(&last); /* what opens no session does not keep it awake */
        int waiting = !board.connected ? (idle > 0 ? (int)idle : 0) : ((board.answered || paced || left < 0) ? 0 : (int)left);
        int ready = link_ready(waiting);
        if (!board.connected && (!ready || idle <= 0)) break; /* nobody came */
        if (!board.connected) clock_gettime(CLOCK_MONOTONIC, &due);
        if (paced && board.connected) pace(&due);
        hal_wired.stopped = stopped;
        for (int k = 0; k < AT_ONCE; k++) {
            size_t bytes = hal_receive(data, sizeof data, sender);
            if (bytes == 0) break;
            size_t answer = delta_board_received(&board, data, bytes, sender, reply);
            if (answer > 0) hal_send(reply, answer, sender);
            if (!served && board.connected) clock_gettime(CLOCK_MONOTONIC, &last);
            served = served || board.connected;
        }
        if (board.connected && (board.answered || paced || since(&last) >= PATIENCE_MS)) {
            clock_gettime(CLOCK_MONOTONIC, &last);
            size_t state = delta_board_tick(&board, reply);
            if (state > 0) hal_send(reply, state, board.peer);
        }
    }
    printf("%lu sessions, %lu commands served, %lu late, %lu dropped\n", board.sessions, board.served, board.late,
           board.dropped);
    return 0;
}
