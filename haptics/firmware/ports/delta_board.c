#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "fast-math drops NaN, by which wrong readings and commands are known"
#endif
#include "delta_board.h"
#include "delta_device.h"
#include "delta_hal.h"
#include "delta_joints.h"
#include <math.h>
#include <string.h>

enum { HELLO = 1, WELCOME, STATE, COMMAND, BYE, REFUSED };
enum { HEAD = 28, CHECK = 4, VERSION = 1 };
enum { WRONG_VERSION = 1, BUSY, WATCHDOG };
enum { TRIPPED = 1, STOPPED = 2, RESET_WATCHDOG = 1, WALL_TOUCHED = 2, DAMPS_AT_WALLS = 1, NOT_FRESH = 4 };
#define LONGEST_WATCHDOG 0.1
static const unsigned char magic[4] = { 'D', 'H', 'A', 'P' };

static uint32_t checksum(const unsigned char *data, size_t bytes)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t k = 0; k < bytes; k++) {
        crc ^= data[k];
        for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

static void put(unsigned char *at, uint64_t value, int bytes)
{
    for (int k = 0; k < bytes; k++) at[k] = (unsigned char)(value >> (8 * k));
}

static uint64_t get(const unsigned char *at, int bytes)
{
    uint64_t value = 0;
    for (int k = 0; k < bytes; k++) value |= (uint64_t)at[k] << (8 * k);
    return value;
}

static void put_real(unsigned char *at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(at, bits, 8);
}

static double get_real(const unsigned char *at)
{
    uint64_t bits = get(at, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static size_t payload(int kind)
{
    switch (kind) {
    case HELLO: return 8;
    case WELCOME: return 28;
    case STATE:
    case COMMAND: return 24;
    case REFUSED: return 4;
    default: return 0;
    }
}

static size_t close_packet(const delta_board *board, unsigned char *packet, int kind, unsigned flags, uint32_t session,
                           uint32_t sequence, uint32_t answers)
{
    size_t body = HEAD + payload(kind);
    memcpy(packet, magic, sizeof magic);
    packet[4] = VERSION;
    packet[5] = (unsigned char)kind;
    put(packet + 6, flags, 2);
    put(packet + 8, session, 4);
    put(packet + 12, sequence, 4);
    put(packet + 16, answers, 4);
    put(packet + 20, (uint64_t)(board->time * 1e9 + 0.5), 8);
    put(packet + body, checksum(packet, body), 4);
    return body + CHECK;
}

static size_t own_packet(delta_board *board, unsigned char *packet, int kind, unsigned flags)
{
    if (++board->sequence == 0) board->sequence = 1;
    if (board->issued < 0x80000000u) board->issued++;
    return close_packet(board, packet, kind, flags, board->session, board->sequence, board->heard);
}

static size_t refusal(const delta_board *board, unsigned char *packet, uint32_t session, uint32_t answers, int reason)
{
    put(packet + HEAD, (uint64_t)reason, 2);
    put(packet + HEAD + 2, VERSION, 2);
    return close_packet(board, packet, REFUSED, 0, session, 1, answers);
}

static int newer(uint32_t sequence, uint32_t than)
{
    uint32_t ahead = sequence - than;
    return ahead != 0 && ahead < 0x80000000u;
}

static void end(delta_board *board)
{
    static const delta_real none[3] = { 0, 0, 0 };
    board->connected = board->tripped = board->held = board->touched = 0;
    for (int j = 0; j < 3; j++) board->torque[j] = 0.0;
    delta_joints_write(none, 0);
}

void delta_board_begin(delta_board *board, double period, double torque_limit, uint32_t counts_per_turn)
{
    memset(board, 0, sizeof *board);
    board->period = board->passed = period;
    board->torque_limit = torque_limit;
    board->counts_per_turn = counts_per_turn;
    board->watchdog = 0.02;
}

/* Number before a session's first: by the time, so that commands that were recorded in an old session answer nothing. */
static uint32_t first(const delta_board *board, uint32_t session)
{
    double now = hal_now();
    uint64_t mixed;
    memcpy(&mixed, &now, sizeof mixed);
    mixed = (mixed ^ session ^ ((uint64_t)board->sessions << 32)) * 0x9e3779b97f4a7c15u;
    mixed = (mixed ^ (mixed >> 29)) * 0xbf58476d1ce4e5b9u;
    return (uint32_t)(mixed >> 34); /* 30 bits: newer than the 0 of a host that has taken nothing */
}

static size_t hello(delta_board *board, const unsigned char *data, uint32_t session, uint32_t sequence,
                    const unsigned char *peer, unsigned char *reply)
{
    double asked = get_real(data + HEAD);
    int same = board->connected && memcmp(peer, board->peer, DELTA_PEER) == 0;
    if (board->connected && !same && !board->tripped) return refusal(board, reply, session, sequence, BUSY);
    if (!(asked >= board->period && asked <= LONGEST_WATCHDOG)) {
        return refusal(board, reply, session, sequence, WATCHDOG);
    }
    int again = same && session == board->session;
    if (!again) {
        end(board);
        memcpy(board->peer, peer, DELTA_PEER);
        board->connected = board->answered = 1;
        board->session = session;
        board->watchdog = asked;
        board->sequence = first(board, session);
        board->issued = 0;
        board->silent = 0.0;
        board->sessions++;
    }
    if (!again || newer(sequence, board->heard)) board->heard = sequence;
    put_real(reply + HEAD, board->period);
    put_real(reply + HEAD + 8, board->watchdog);
    put_real(reply + HEAD + 16, board->torque_limit);
    put(reply + HEAD + 24, board->counts_per_turn, 4);
    return own_packet(board, reply, WELCOME, DELTA_CONTACT_DAMPING > DELTA_DAMPING ? DAMPS_AT_WALLS : 0u);
}

static void command(delta_board *board, const unsigned char *data, uint32_t sequence)
{
    board->heard = sequence;
    board->answered = 1;
    board->served++;
    if (get(data + 16, 4) != board->sequence) board->late++;
    if (get(data + 6, 2) & RESET_WATCHDOG) {
        board->tripped = board->held = 0;
        board->silent = 0.0;
    }
    board->touched = (get(data + 6, 2) & WALL_TOUCHED) != 0;
    for (int j = 0; j < 3; j++) {
        double asked = get_real(data + HEAD + 8 * j);
        double most = board->torque_limit;
        board->torque[j] = asked > most ? most : (asked < -most ? -most : asked);
    }
}

size_t delta_board_received(delta_board *board, const unsigned char *data, size_t bytes,
                            const unsigned char peer[DELTA_PEER], unsigned char reply[DELTA_PACKET_MOST])
{
    if (bytes < HEAD + CHECK || memcmp(data, magic, sizeof magic) != 0 ||
        get(data + bytes - CHECK, 4) != checksum(data, bytes - CHECK)) {
        board->dropped++;
        return 0;
    }
    int kind = data[5];
    if (data[4] != VERSION) {
        board->dropped++;
        return refusal(board, reply, 0, 0, WRONG_VERSION);
    }
    int good = kind >= HELLO && kind <= REFUSED && bytes == HEAD + CHECK + payload(kind);
    for (size_t at = HEAD; good && (kind == HELLO || kind == COMMAND) && at + 8 <= bytes - CHECK; at += 8) {
        good = isfinite(get_real(data + at)) != 0;
    }
    if (!good) {
        board->dropped++;
        return 0;
    }
    uint32_t session = (uint32_t)get(data + 8, 4), sequence = (uint32_t)get(data + 12, 4);
    if (kind == HELLO) return hello(board, data, session, sequence, peer, reply);
    if (!board->connected || memcmp(peer, board->peer, DELTA_PEER) != 0 || session != board->session) {
        board->dropped++;
        return 0;
    }
    if (kind == BYE) return delta_board_farewell(board, reply);
    uint32_t behind = board->sequence - (uint32_t)get(data + 16, 4);
    if (kind == COMMAND && newer(sequence, board->heard) && behind < board->issued) {
        command(board, data, sequence);
    } else {
        board->dropped++;
    }
    return 0;
}

size_t delta_board_tick(delta_board *board, unsigned char state[DELTA_PACKET_MOST])
{
    delta_real torque[3], theta[3];
    int fresh[3], stopped = hal_stop_pressed();
    if (board->connected) {
        board->silent = board->answered ? 0.0 : board->silent + board->passed;
        if (board->silent > board->watchdog + 0.5 * board->period || !hal_healthy()) board->tripped = 1;
    }
    board->held = stopped || (board->held && board->connected); /* a stop that is released gives no torque back */
    int off = board->tripped || board->held || !board->connected;
    for (int j = 0; j < 3; j++) torque[j] = off ? 0 : (delta_real)board->torque[j];
    delta_joints_write(torque, !off && board->touched);
    hal_watchdog();
    hal_wait();
    double before = board->time;
    board->time = delta_joints_read(theta, fresh);
    /* a tick that comes late counts for all the time that it took */
    board->passed = board->time - before > board->period ? board->time - before : board->period;
    if (!board->connected) return 0;
    board->answered = 0;
    for (int j = 0; j < 3; j++) put_real(state + HEAD + 8 * j, (double)theta[j]);
    unsigned flags = (board->tripped || (board->held && !stopped) ? TRIPPED : 0u) | (stopped ? STOPPED : 0u);
    for (int j = 0; j < 3; j++) flags |= fresh[j] ? 0u : (unsigned)NOT_FRESH << j;
    return own_packet(board, state, STATE, flags);
}

size_t delta_board_farewell(delta_board *board, unsigned char bye[DELTA_PACKET_MOST])
{
    if (!board->connected) return 0;
    size_t bytes = own_packet(board, bye, BYE, 0);
    end(board);
    return bytes;
}
