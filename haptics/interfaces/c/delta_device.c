/* See delta_device.h. */
#define _POSIX_C_SOURCE 200809L
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "fast-math drops NaN, by which wrong readings and commands are known"
#endif
#include "delta_device.h"
#include "delta_pose.h"

#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define TWO_PI 6.28318530717958647692
#define TRIES 5
#define LARGEST 64 /* of a packet that is read, bytes; those of the protocol have at most 60 */
#define HEADER 28
#define NOT_FRESH 28u /* flags of a STATE, a bit a joint */
#define NS 1e9

enum kind { HELLO = 1, WELCOME = 2, STATE = 3, COMMAND = 4, BYE = 5, REFUSED = 6 };

struct packet {
    unsigned kind, flags;
    uint32_t session, sequence, answers;
    uint64_t time;
    double values[3];
};

struct delta_device {
    delta_config config;
    int socket;
    uint32_t session, sequence, heard;
    uint32_t cleared; /* number of the command that ends the board's watchdog */
    uint64_t time;
    double period, watchdog, torque_limit;
    double angles[3], rates[3], torques[3];
    double pose[POSE_ROWS][3]; /* first three rows: velocity of the handle by the rate of each joint; see delta_pose.h */
    double share;              /* of the force that is let in, 0 to 1 */
    int known, lost, reset, ending, begun; /* ending: until the board answers that command */
    unsigned flags;
};

/* ---- bytes ---- */

static void put(uint8_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

static uint64_t get(const uint8_t *at, int bytes)
{
    uint64_t value = 0;
    for (int i = bytes; i-- > 0;)
        value = value << 8 | at[i];
    return value;
}

static void put_double(uint8_t *at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(at, bits, 8);
}

static double get_double(const uint8_t *at)
{
    uint64_t bits = get(at, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint32_t check_sum(const uint8_t *data, size_t length)
{
    uint32_t sum = 0xFFFFFFFFu;
    for (size_t i = 0; i < length; i++) {
        sum ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            sum = sum >> 1 ^ (sum & 1u ? 0xEDB88320u : 0u);
    }
    return ~sum;
}

/* Doubles in a packet's payload; -1 for a kind that no board sends. */
static int doubles_of(unsigned kind)
{
    return kind == WELCOME || kind == STATE ? 3 : kind == BYE || kind == REFUSED ? 0 : -1;
}

/* Reads a datagram; 0 if it is none of ours. A WELCOME's count and a REFUSED's words are left unread. */
static int decoded(const uint8_t *data, size_t length, struct packet *packet)
{
    if (length < HEADER + 4 || memcmp(data, "DHAP", 4) != 0 || data[4] != 1)
        return 0;
    if (get(data + length - 4, 4) != check_sum(data, length - 4))
        return 0;
    packet->kind = data[5];
    int count = doubles_of(packet->kind);
    size_t more = packet->kind == WELCOME || packet->kind == REFUSED ? 4 : 0;
    if (count < 0 || length != HEADER + 8 * (size_t)count + more + 4)
        return 0;
    packet->flags = (unsigned)get(data + 6, 2);
    packet->session = (uint32_t)get(data + 8, 4);
    packet->sequence = (uint32_t)get(data + 12, 4);
    packet->answers = (uint32_t)get(data + 16, 4);
    packet->time = get(data + 20, 8);
    for (int i = 0; i < count; i++) {
        packet->values[i] = get_double(data + HEADER + 8 * i);
        if (!isfinite(packet->values[i]) && !(packet->kind == STATE && isnan(packet->values[i])))
            return 0;
    }
    return 1;
}

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int sent(delta_device *device, unsigned kind, const double *values, int count, unsigned flags)
{
    uint8_t data[LARGEST];
    size_t length = HEADER + 8 * (size_t)count;
    device->sequence += 1;
    if (device->sequence == 0)
        device->sequence = 1;
    memcpy(data, "DHAP", 4);
    data[4] = 1;
    data[5] = (uint8_t)kind;
    put(data + 6, flags, 2);
    put(data + 8, device->session, 4);
    put(data + 12, device->sequence, 4);
    put(data + 16, device->heard, 4);
    put(data + 20, (uint64_t)(now() * NS), 8);
    for (int i = 0; i < count; i++)
        put_double(data + HEADER + 8 * i, values[i]);
    put(data + length, check_sum(data, length), 4);
    return send(device->socket, data, length + 4, MSG_NOSIGNAL) == (ssize_t)(length + 4);
}

/* The next packet of this session that is newer than the last, until a time; 0: none, -1: the other end is gone. Noise
 * without an end and signals to the program do not hold it up, nor does what was there and is gone when it is read. */
static int received(delta_device *device, double end, struct packet *packet)
{
    for (int more = 1; more;) {
        uint8_t data[LARGEST];
        double left = end - now();
        struct pollfd waiting = {device->socket, POLLIN, 0};
        more = left > 0.0;
        int ready = poll(&waiting, 1, more ? (int)ceil(1e3 * left) : 0);
        if (ready <= 0) {
            if (ready < 0 && errno != EINTR)
                return -1;
            continue;
        }
        ssize_t length = recv(device->socket, data, sizeof data, MSG_DONTWAIT);
        if (length < 0 && errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK)
            return -1;
        if (length < 0 || !decoded(data, (size_t)length, packet))
            continue;
        if (packet->kind == REFUSED && device->heard == 0)
            return 1;
        uint32_t ahead = packet->sequence - device->heard;
        if (packet->session != device->session || ahead == 0 || ahead >= 0x80000000u)
            continue;
        device->heard = packet->sequence;
        return 1;
    }
    return 0;
}

/* Says something until it is answered, some times at most. */
static int asked(delta_device *device, unsigned kind, const double *values, int count, unsigned reply,
                 struct packet *packet)
{
    for (int n = 0; n < TRIES; n++) {
        if (!sent(device, kind, values, count, 0))
            return DELTA_NO_BOARD;
        double end = now() + device->config.timeout;
        int got;
        while ((got = received(device, end, packet)) > 0) {
            if (packet->kind == reply)
                return DELTA_OK;
            if (packet->kind == REFUSED)
                return DELTA_REFUSED;
        }
        if (got < 0)
            return DELTA_NO_BOARD;
    }
    return DELTA_NO_BOARD;
}

/* ---- the mechanism ---- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Position, Jacobian and holding torques of the device's angles; whether there is a position: without one the margin to
 * a singularity is no number. */
static int posed(delta_device *device)
{
    const delta_config *c = &device->config;
    const Model known = {c->radius_difference, c->side_difference, c->side_cosine, c->side_sine,  c->upper_arm_length,
                         c->forearm_length,    c->hanging,         c->moment,      c->across,     c->gravity[0],
                         c->gravity[1],        c->gravity[2]};
    row angles = {device->angles, 3};
    table pose = {&device->pose[0][0], POSE_ROWS, 3, 3};
    return pose_pose(&known, angles, pose).v1 > 0.0;
}

static void took(delta_device *device, const struct packet *packet)
{
    double step = (double)(packet->time - device->time) / NS;
    int sound = (packet->flags & NOT_FRESH) == 0u;
    for (int i = 0; i < 3; i++)
        sound = sound && isfinite(packet->values[i]);
    for (int i = 0; i < 3; i++) {
        double turn = packet->values[i] - device->angles[i];
        if (!sound || !device->known || !(step > 0.0))
            device->rates[i] = 0.0;
        else
            device->rates[i] += (1.0 - exp(-TWO_PI * device->config.corner * step)) * (turn / step - device->rates[i]);
        device->angles[i] = packet->values[i];
    }
    device->time = packet->time;
    device->known = sound && posed(device);
    unsigned up = (packet->flags & 3u) | (device->known ? 0u : (unsigned)DELTA_POSE_UNKNOWN);
    uint32_t since = packet->answers - device->cleared;
    device->ending = device->ending && since >= 0x80000000u;
    if (device->ending)
        up &= ~(unsigned)DELTA_WATCHDOG; /* the command that ends it is on its way */
    if ((device->begun ? up : up & ~(unsigned)DELTA_WATCHDOG) != 0u)
        device->flags |= DELTA_LATCHED;
    device->flags = (device->flags & DELTA_LATCHED) | up;
    if (device->flags != 0u)
        device->share = 0.0;
    else if (device->config.ramp > 0.0)
        device->share = fmin(1.0, device->share + fmin(step, device->period) / device->config.ramp);
    else
        device->share = 1.0;
}

/* Takes the newest of the readings that come until a time, or are there; DELTA_NO_BOARD: there is none. */
static int newest(delta_device *device, double end)
{
    struct packet packet, last = {0};
    int any = 0, got;
    while ((got = received(device, any ? 0.0 : end, &packet)) > 0) {
        if (packet.kind == BYE)
            return DELTA_LOST;
        if (packet.kind == STATE) {
            last = packet;
            any = 1;
        }
    }
    if (got < 0 || !any)
        return got < 0 ? DELTA_LOST : DELTA_NO_BOARD;
    took(device, &last);
    return DELTA_OK;
}

/* Waits for a reading. */
static int heard(delta_device *device)
{
    if (newest(device, now() + device->config.timeout) == DELTA_OK)
        return DELTA_OK;
    device->lost = 1;
    return DELTA_LOST;
}

/* Before the first command: what the board has done while the program was not ready harms nobody, and ends now. */
static void begin(delta_device *device)
{
    device->lost = newest(device, 0.0) == DELTA_LOST;
    device->begun = 1;
    device->reset = device->reset || (device->flags & DELTA_WATCHDOG) != 0u;
    device->flags &= ~(unsigned)DELTA_WATCHDOG;
}

/* Torques of a force: the weight first, then as much of the force as fits, in its direction. */
static void weighed(delta_device *device, const double force[3])
{
    double limit = device->config.torque_limit, share = device->share, size = sqrt(dot(force, force));
    double wanted[3];
    if (size > device->config.force_limit)
        share *= device->config.force_limit / size;
    double fits = 1.0;
    for (int i = 0; i < 3; i++) {
        double held = fmax(-limit, fmin(limit, device->pose[POSE_HOLDING][i]));
        wanted[i] = share * dot(device->pose[i], force);
        double room = wanted[i] > 0.0 ? limit - held : limit + held;
        if (fabs(wanted[i]) > room)
            fits = fmin(fits, room / fabs(wanted[i]));
    }
    for (int i = 0; i < 3; i++)
        device->torques[i] = fmax(-limit, fmin(limit, device->pose[POSE_HOLDING][i])) + fits * wanted[i];
}

/* ---- what programs call ---- */

static int sound(const delta_config *c)
{
    const double positive[] = {c->upper_arm_length, c->forearm_length, c->torque_limit, c->force_limit,
                               c->corner,           c->watchdog,       c->timeout};
    const double any[] = {c->radius_difference, c->side_difference, c->across, c->gravity[0],
                          c->gravity[1],        c->gravity[2],      c->moment};
    for (size_t i = 0; i < sizeof positive / sizeof *positive; i++)
        if (!(positive[i] > 0.0 && isfinite(positive[i])))
            return 0;
    for (size_t i = 0; i < sizeof any / sizeof *any; i++)
        if (!isfinite(any[i]))
            return 0;
    double circle = c->side_cosine * c->side_cosine + c->side_sine * c->side_sine;
    if (!(fabs(circle - 1.0) < 1e-9 && c->side_sine > 0.0))
        return 0;
    return c->hanging >= 0.0 && isfinite(c->hanging) && c->ramp >= 0.0 && isfinite(c->ramp) && c->timeout < 3600.0;
}

static int is_loopback(const struct sockaddr *address)
{
    if (address->sa_family == AF_INET6) {
        struct sockaddr_in6 six;
        memcpy(&six, address, sizeof six);
        return IN6_IS_ADDR_LOOPBACK(&six.sin6_addr);
    }
    struct sockaddr_in four;
    memcpy(&four, address, sizeof four);
    return ntohl(four.sin_addr.s_addr) >> 24 == 127;
}

/* A socket to an address; -1 and *status where there is none. */
static int connected(const delta_config *config, const char *address, uint16_t port, int *status)
{
    char service[8];
    struct addrinfo hints = {0}, *found = NULL;
    hints.ai_socktype = SOCK_DGRAM;
    hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
    snprintf(service, sizeof service, "%u", (unsigned)port);
    *status = DELTA_NO_ADDRESS;
    if (getaddrinfo(address, service, &hints, &found) != 0)
        return -1;
    int handle = -1;
    if (config->allow_remote || is_loopback(found->ai_addr)) {
        *status = DELTA_NO_BOARD;
        handle = socket(found->ai_family, found->ai_socktype, found->ai_protocol);
        if (handle >= 0 && connect(handle, found->ai_addr, found->ai_addrlen) != 0) {
            close(handle);
            handle = -1;
        }
    }
    freeaddrinfo(found);
    return handle;
}

static uint32_t drawn(void)
{
    uint32_t number = 0;
    FILE *file = fopen("/dev/urandom", "rb");
    if (file != NULL) {
        if (fread(&number, sizeof number, 1, file) != 1)
            number = 0;
        fclose(file);
    }
    return number != 0 ? number : (uint32_t)(uint64_t)(now() * NS) ^ (uint32_t)getpid() << 16;
}

delta_device *delta_open(const delta_config *config, const char *address, uint16_t port, int *status)
{
    int ignored;
    status = status != NULL ? status : &ignored;
    *status = DELTA_BAD_ARGUMENT;
    if (config == NULL || address == NULL || !sound(config))
        return NULL;
    delta_device *device = calloc(1, sizeof *device);
    if (device == NULL)
        return NULL;
    device->config = *config;
    device->socket = connected(config, address, port, status);
    if (device->socket < 0) {
        free(device);
        return NULL;
    }
    struct packet welcome;
    device->session = drawn();
    *status = asked(device, HELLO, &config->watchdog, 1, WELCOME, &welcome);
    if (*status == DELTA_OK) {
        device->period = welcome.values[0];
        device->watchdog = welcome.values[1];
        device->torque_limit = welcome.values[2];
        device->time = welcome.time;
        *status = device->torque_limit < config->torque_limit ? DELTA_UNFIT : heard(device);
        if (*status == DELTA_OK)
            return device;
        asked(device, BYE, NULL, 0, BYE, &welcome);
    }
    close(device->socket);
    free(device);
    return NULL;
}

int delta_position(const delta_device *device, double position[3])
{
    if (device == NULL || position == NULL)
        return DELTA_BAD_ARGUMENT;
    if (!device->known)
        return DELTA_UNKNOWN;
    memcpy(position, device->pose[POSE_POSITION], sizeof device->pose[POSE_POSITION]);
    return DELTA_OK;
}

int delta_velocity(const delta_device *device, double velocity[3])
{
    if (device == NULL || velocity == NULL)
        return DELTA_BAD_ARGUMENT;
    if (!device->known)
        return DELTA_UNKNOWN;
    for (int k = 0; k < 3; k++)
        velocity[k] = device->pose[0][k] * device->rates[0] + device->pose[1][k] * device->rates[1]
                      + device->pose[2][k] * device->rates[2];
    return DELTA_OK;
}

int delta_angles(const delta_device *device, double angles[3])
{
    if (device == NULL || angles == NULL)
        return DELTA_BAD_ARGUMENT;
    memcpy(angles, device->angles, sizeof device->angles);
    return DELTA_OK;
}

int delta_torques(const delta_device *device, double torques[3])
{
    if (device == NULL || torques == NULL)
        return DELTA_BAD_ARGUMENT;
    memcpy(torques, device->torques, sizeof device->torques);
    return DELTA_OK;
}

int delta_set_force(delta_device *device, const double force[3])
{
    if (device == NULL || force == NULL)
        return DELTA_BAD_ARGUMENT;
    for (int k = 0; k < 3; k++)
        if (!isfinite(force[k]))
            return DELTA_BAD_ARGUMENT;
    if (!device->begun && !device->lost)
        begin(device);
    if (device->lost)
        return DELTA_LOST;
    memset(device->torques, 0, sizeof device->torques);
    if (device->flags == 0u)
        weighed(device, force);
    if (!sent(device, COMMAND, device->torques, 3, device->reset ? 1u : 0u)) {
        device->lost = 1;
        return DELTA_LOST;
    }
    if (device->reset) {
        device->cleared = device->sequence;
        device->ending = 1;
    }
    device->reset = 0;
    return heard(device);
}

unsigned delta_flags(const delta_device *device)
{
    return device == NULL ? (unsigned)DELTA_LATCHED : device->flags;
}

int delta_reset(delta_device *device)
{
    if (device == NULL)
        return DELTA_BAD_ARGUMENT;
    device->reset = 1;
    device->flags &= ~(unsigned)(DELTA_LATCHED | DELTA_WATCHDOG);
    device->share = 0.0;
    return DELTA_OK;
}

double delta_period(const delta_device *device)
{
    return device == NULL ? 0.0 : device->period;
}

double delta_time(const delta_device *device)
{
    return device == NULL ? 0.0 : (double)device->time / NS;
}

int delta_close(delta_device *device)
{
    struct packet packet;
    if (device == NULL)
        return DELTA_OK;
    if (!device->lost) {
        const double none[3] = {0.0, 0.0, 0.0};
        sent(device, COMMAND, none, 3, 0);
        asked(device, BYE, NULL, 0, BYE, &packet);
    }
    close(device->socket);
    free(device);
    return DELTA_OK;
}

const char *delta_text(int status)
{
    static const char *const texts[] = {
        "done",
        "an argument is missing, or a number is not finite or out of its bounds",
        "the address is not numeric, or is of another machine and that is not allowed",
        "no board answers",
        "the board refuses: it has a host already, speaks another version, or dislikes the watchdog",
        "the board clips torques that the machine's numbers allow",
        "the board is lost",
        "no position of the handle fits the angles",
    };
    return status >= 0 && (size_t)status < sizeof texts / sizeof *texts ? texts[status] : "no status";
}
