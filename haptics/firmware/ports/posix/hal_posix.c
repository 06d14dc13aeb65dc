/* The hardware layer on a POSIX machine: the simulated device in place of encoders and drives, UDP in place of a link. */
#define _POSIX_C_SOURCE 200809L
#include "hal_posix.h"
#include "../delta_controller.h"
#include "../delta_device.h"
#include "../delta_hal.h"
#include "device.h"
#include <arpa/inet.h>
#include <errno.h>
#include <math.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

hal_wiring hal_wired = { { 1, 1, 1 }, { 1, 1, 1 }, 0, NULL };
static int begun, powered, listening = -1;
static long long ticks;
static double torque[3], current[3], angle[3];
static struct timespec due;

int hal_begin(void)
{
    ticks = 0;
    begun = powered = 0;
    clock_gettime(CLOCK_MONOTONIC, &due);
    return 0;
}

void hal_wait(void)
{
    if (begun) {
        for (int j = 0; j < 3; j++) torque[j] = powered ? hal_wired.motor[j] * current[j] / DELTA_AMPERE_PER_N_M : 0.0;
        device_step(torque, DELTA_PERIOD_S);
        ticks++;
    }
    begun = 1;
    device_angles(angle);
    if (!hal_wired.paced) return;
    due.tv_nsec += (long)(DELTA_PERIOD_S * 1e9);
    if (due.tv_nsec >= 1000000000L) {
        due.tv_nsec -= 1000000000L;
        due.tv_sec++;
    }
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL) == EINTR) {}
}

double hal_now(void) { return (double)ticks * DELTA_PERIOD_S; }

int hal_encoder(int joint, double *found)
{
    double count = DELTA_COUNT_RAD;
    *found = hal_wired.encoder[joint] * nearbyint(angle[joint] / count) * count;
    return isfinite(*found) ? 0 : 1;
}

void hal_current(int joint, double ampere) { current[joint] = ampere; }
void hal_enable(int on) { powered = on; }
int hal_healthy(void) { return 1; }
int hal_stop_pressed(void) { return hal_wired.stopped != NULL && *hal_wired.stopped; }
void hal_watchdog(void) {}

void hal_report(int event, int joint, double value, double bound)
{
    printf("event %d %d %.9g %.9g\n", event, joint, value, bound);
}

int hal_posix_listen(int port)
{
    struct sockaddr_in own;
    socklen_t size = sizeof own;
    memset(&own, 0, sizeof own);
    own.sin_family = AF_INET;
    own.sin_port = htons((uint16_t)port);
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK); /* no password: this machine only */
    listening = socket(AF_INET, SOCK_DGRAM, 0);
    if (listening < 0 || bind(listening, (struct sockaddr *)&own, sizeof own) != 0) return -1;
    if (getsockname(listening, (struct sockaddr *)&own, &size) != 0) return -1;
    return ntohs(own.sin_port);
}

int hal_posix_ready(int milliseconds)
{
    struct pollfd one = { listening, POLLIN, 0 };
    return poll(&one, 1, milliseconds) > 0;
}

size_t hal_receive(unsigned char *data, size_t most, unsigned char sender[32])
{
    struct sockaddr_in from;
    socklen_t size = sizeof from;
    memset(&from, 0, sizeof from);
    ssize_t got = recvfrom(listening, data, most, MSG_DONTWAIT, (struct sockaddr *)&from, &size);
    memset(sender, 0, 32);
    memcpy(sender, &from, sizeof from);
    return got > 0 ? (size_t)got : 0;
}

void hal_send(const unsigned char *data, size_t bytes, const unsigned char to[32])
{
    struct sockaddr_in peer;
    memcpy(&peer, to, sizeof peer);
    (void)sendto(listening, data, bytes, 0, (struct sockaddr *)&peer, sizeof peer); /* a lost one is a missed tick */
}
