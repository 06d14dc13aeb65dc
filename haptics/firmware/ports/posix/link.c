#define _POSIX_C_SOURCE 200809L
#include "link.h"
#include "../delta_hal.h"
#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>

static int listening = -1;

int link_listen(int port)
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

int link_ready(int milliseconds)
{
    struct pollfd one = { listening, POLLIN, 0 };
    int ready = poll(&one, 1, milliseconds);
    return ready > 0 || (ready < 0 && errno == EINTR); /* a signal is somebody, too */
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
