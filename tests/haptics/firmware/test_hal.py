"""The C that is written by hand, alone: what each wire says and is given, on hardware and a controller made up here.

The controller in the stub headers is no more than factors by which each step is known: readings are doubled by
`delta_drawn`, turned into torques as they are by `delta_tick`, and three times as large after `delta_turned`.
"""

from __future__ import annotations

import math
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

from haptics.devices.protocol import Packet, PacketKind, decode, encode
from haptics.firmware.ports import files_of_ports
from tests.haptics.firmware.rig import FLAGS, tool

DEVICE = """
#ifndef DELTA_DEVICE_H
#define DELTA_DEVICE_H
#define DELTA_AMPERE_PER_N_M 2.0
#define DELTA_DAMPING 0.25
#define DELTA_CONTACT_DAMPING 0.75
#endif
"""
CONTROLLER = """
#ifndef DELTA_CONTROLLER_H
#define DELTA_CONTROLLER_H
typedef double delta_real;
typedef struct { int none; } delta_startup_memory;
typedef struct { int none; } delta_memory;
typedef struct { int none; } delta_made;
typedef struct { int joint, code; double value, bound; } delta_refusal;
enum { DELTA_STARTUP_READY = 10, DELTA_STARTUP_REFUSED = 11, DELTA_STATE_FAULT = 4 };
#define DELTA_EMERGENCY_STOP 1LL
#define DELTA_WATCHDOG 2LL
void delta_startup_begin(delta_startup_memory *start);
void delta_startup_signal(delta_startup_memory *start, long long bits);
long long delta_startup_tick(delta_startup_memory *start, double now, const delta_real theta[3], const int fresh[3],
                             delta_real torque[3]);
int delta_startup_step(const delta_startup_memory *start);
delta_refusal delta_startup_refusal(const delta_startup_memory *start);
void delta_startup_offsets(const delta_startup_memory *start, delta_real offset[3]);
void delta_start(delta_memory *memory);
void delta_enable(delta_memory *memory);
void delta_signal(delta_memory *memory, long long bits);
void delta_heard(delta_memory *memory, double now);
long long delta_tick(delta_memory *memory, const delta_real *laws, long rows, double now, const delta_real theta[3],
                     const delta_real reading[3], const int fresh[3], delta_real torque[3]);
int delta_state(const delta_memory *memory);
int delta_touched(const delta_memory *memory);
void delta_shoulders(const delta_real raw[3], delta_real theta[3]);
void delta_drawn(delta_made *made, const delta_real raw[3], delta_real theta[3]);
void delta_turned(const delta_made *made, const delta_real torque[3], delta_real turned[3]);
#endif
"""
HARDWARE = """
#include "delta_board.h"
#include "delta_hal.h"
#include "delta_joints.h"
#include "delta_run.h"
#include <stdio.h>
#include <string.h>
static int fault = -1, healthy = 1, pressed = 0, on = 0;
static double now = 0.0, ampere[3], damping[3], at_work[4]; /* the last: currents and damping at a sign of life */
int hal_begin(void) { return 0; }
void hal_wait(void) { now += 1e-3; }
double hal_now(void) { return now; }
int hal_encoders(double angle[3], int fresh[3])
{
    for (int j = 0; j < 3; j++) {
        angle[j] = 0.1 * (j + 1);
        fresh[j] = j != fault;
    }
    return fault == 3;
}
void hal_damping(int joint, double share) { damping[joint] = share; }
void hal_current(int joint, double value) { ampere[joint] = value; }
void hal_enable(int wanted) { on = wanted; }
int hal_healthy(void) { return healthy; }
int hal_stop_pressed(void) { return pressed; }
void hal_watchdog(void)
{
    memcpy(at_work, ampere, sizeof ampere);
    at_work[3] = damping[0];
}
void hal_report(int event, int joint, double value, double bound)
{
    (void)event; (void)joint; (void)value; (void)bound;
}
"""
JOINTS = """
int main(int count, char **words)
{
    int fresh[3];
    delta_real theta[3], torque[3] = { 0.5, -0.25, 0.125 };
    (void)words;
    fault = count - 2;
    delta_joints_read(theta, fresh);
    delta_joints_write(torque, 0);
    printf("%d %d %d ", fresh[0], fresh[1], fresh[2]);
    printf("%g %g %g %g %g %g %g", theta[0], theta[1], theta[2], ampere[0], ampere[1], ampere[2], damping[2]);
    delta_joints_write(torque, 1);
    printf(" %g", damping[2]);
    for (int k = 0; k < 4; k++) {
        healthy = (k & 1) == 0;
        pressed = (k & 2) != 0;
        printf(" %lld", delta_joints_signals());
    }
    return 0;
}
"""
RUN = """
static int ticks = 0, state = 2;
static void scaled(const delta_real *from, delta_real *to, double by)
{
    for (int j = 0; j < 3; j++) to[j] = by * from[j];
}
void delta_startup_begin(delta_startup_memory *start) { start->none = 0; }
void delta_startup_signal(delta_startup_memory *start, long long bits) { (void)start; (void)bits; }
long long delta_startup_tick(delta_startup_memory *start, double time, const delta_real theta[3], const int fresh[3],
                             delta_real torque[3])
{
    (void)start; (void)time; (void)fresh;
    scaled(theta, torque, 0.0);
    return 0;
}
int delta_startup_step(const delta_startup_memory *start) { (void)start; return ticks++ < 3 ? 0 : DELTA_STARTUP_READY; }
delta_refusal delta_startup_refusal(const delta_startup_memory *start)
{
    delta_refusal none = { 0, 0, 0.0, 0.0 };
    (void)start;
    return none;
}
void delta_startup_offsets(const delta_startup_memory *start, delta_real offset[3])
{
    (void)start;
    for (int j = 0; j < 3; j++) offset[j] = 0.01 * (j + 1);
}
void delta_start(delta_memory *memory) { memory->none = 0; }
void delta_enable(delta_memory *memory) { memory->none = 1; }
void delta_signal(delta_memory *memory, long long bits) { (void)memory; (void)bits; }
void delta_heard(delta_memory *memory, double time) { (void)memory; (void)time; }
long long delta_tick(delta_memory *memory, const delta_real *laws, long rows, double time, const delta_real theta[3],
                     const delta_real reading[3], const int fresh[3], delta_real torque[3])
{
    (void)laws; (void)rows; (void)time; (void)reading; (void)fresh;
    fault = 1; /* the next reading is not fresh: the last place stands */
    scaled(theta, torque, memory->none ? 1.0 : 0.0);
    return 0;
}
int delta_state(const delta_memory *memory) { (void)memory; return state; }
int delta_touched(const delta_memory *memory) { (void)memory; return 1; }
void delta_shoulders(const delta_real raw[3], delta_real theta[3]) { scaled(raw, theta, 1.0); }
void delta_drawn(delta_made *made, const delta_real raw[3], delta_real theta[3])
{
    made->none = 0;
    scaled(raw, theta, 2.0);
}
void delta_turned(const delta_made *made, const delta_real torque[3], delta_real turned[3])
{
    (void)made;
    scaled(torque, turned, 3.0);
}
int main(void)
{
    int ended = delta_run(NULL, 0, 6);
    printf("%d %d", ended, on);
    for (int j = 0; j < 4; j++) printf(" %g", at_work[j]);
    printf(" %g %g %g", ampere[0], ampere[1], ampere[2]);
    return 0;
}
"""
BOARD = """
static delta_board board;
static unsigned char packet[4096], reply[DELTA_PACKET_MOST];
static const unsigned char peer[DELTA_PEER] = { 1 };
/* Reads how many bytes a packet has and the packet, or 0 for a period, and tells the currents after each. */
int main(void)
{
    int bytes;
    delta_board_begin(&board, 1e-3, 0.8, 4096);
    while ((bytes = getchar()) != EOF) {
        size_t out;
        if (bytes == 0) {
            out = delta_board_tick(&board, reply);
        } else {
            if (fread(packet, 1, (size_t)bytes, stdin) != (size_t)bytes) return 1;
            out = delta_board_received(&board, packet, (size_t)bytes, peer, reply);
        }
        printf("%g %g %g %g %d %lu ", ampere[0], ampere[1], ampere[2], damping[0], board.tripped, board.dropped);
        for (size_t k = 0; k < out; k++) printf("%02x", reply[k]);
        printf("\\n");
    }
    return 0;
}
"""


def made(folder: Path, code: str, *parts: str) -> Path:
    """A program of some of the ports' sources and what stands for hardware and controller."""
    files = {name: text for name, text in files_of_ports().items() if name.startswith("delta_")}
    files |= {"delta_device.h": DEVICE, "delta_controller.h": CONTROLLER, "made.c": HARDWARE + code}
    for name, text in files.items():
        (folder / name).write_text(text)
    sources = [str(folder / name) for name in ("made.c", *parts)]
    program = folder / "made"
    command = [tool("gcc"), *FLAGS, "-Wno-unused", f"-I{folder}", *sources, "-o", str(program), "-lm"]
    subprocess.run(command, check=True)
    return program


def printed_figures(program: Path, *words: str) -> list[float]:
    return [
        float(word)
        for word in subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout.split()
    ]


def test_what_the_wires_say_comes_through(tmp_path: Path) -> None:
    """An encoder that is not fresh has no angle, none has without a bus; 2 A for a newton metre; a wall damps more."""
    program = made(tmp_path, JOINTS, "delta_joints.c")
    for fault in (None, 0, 1, 2, 3):
        words = () if fault is None else ("fault",) * (fault + 1)
        *found, a, b, c, free, wall, fine, sick, stopped, both = printed_figures(program, *words)
        fresh, theta = found[:3], found[3:]
        assert fresh == [joint != fault and fault != 3 for joint in range(3)]
        assert [math.isnan(value) for value in theta] == [not one for one in fresh]
        assert [value for value in theta if not math.isnan(value)] == pytest.approx(
            [0.1 * (joint + 1) for joint in range(3) if fresh[joint]]
        )
        assert (a, b, c) == (1.0, -0.5, 0.25)
        assert (free, wall) == (0.25, 0.75)
        assert (fine, sick, stopped, both) == (0.0, 2.0, 1.0, 3.0)


def test_a_calibrated_device_gets_its_torques_turned(tmp_path: Path) -> None:
    """Readings with the start-up's offsets, doubled, turned by 3, 2 A for a newton metre; then all is off."""
    ended, on, *rest = printed_figures(made(tmp_path, RUN, "delta_joints.c", "delta_run.c"))
    assert (ended, on) == (0, 0)
    currents = [2.0 * 3.0 * 2.0 * (0.1 + 0.01) * (joint + 1) for joint in range(3)]
    assert rest == pytest.approx([*currents, 0.75, 0.0, 0.0, 0.0])


class Line(NamedTuple):
    """What a board says after a packet or a period."""

    ampere: tuple[float, float, float]
    damping: float
    tripped: bool
    dropped: int
    reply: Packet | None


def board(program: Path, packets: list[bytes]) -> list[Line]:
    """Gives a board packets one after the other; an empty one is a period without."""
    stream = b"".join(bytes([len(one)]) + one for one in packets)
    lines = subprocess.run([program], input=stream, capture_output=True, check=True).stdout.decode().splitlines()
    found = []
    for line in lines:
        a, b, c, share, tripped, dropped, reply = line.split(" ")
        answer = decode(bytes.fromhex(reply)) if reply else None
        found.append(Line((float(a), float(b), float(c)), float(share), tripped == "1", int(dropped), answer))
    return found


def test_a_command_acts_once_and_within_its_limits(tmp_path: Path) -> None:
    """Watchdog of 2 ms: silence cuts, a command with a reset arms again, the same packet once more does not."""
    program = made(tmp_path, BOARD, "delta_joints.c", "delta_board.c")
    tick, silence = b"", [b""] * 4
    begin = [encode(Packet(PacketKind.HELLO, 7, 1, 0, 0, (2e-3,))), tick]
    *_, welcome, state = board(program, begin)
    assert welcome.reply is not None
    assert welcome.reply.values[:3] == (1e-3, 2e-3, 0.8)
    assert state.reply is not None
    assert state.reply.values == pytest.approx((0.1, 0.2, 0.3))
    answers = state.reply.sequence

    def command(sequence: int, flags: int = 0, torque: float = 0.25, answered: int = answers) -> bytes:
        return encode(Packet(PacketKind.COMMAND, 7, sequence, answered, 0, (9.0, -9.0, torque), flags))

    def after(*packets: bytes) -> Line:
        return board(program, [*begin, *packets])[-1]

    reported = after(command(2, 2), tick)
    assert (reported.ampere, reported.damping, reported.dropped) == (
        (1.6, -1.6, 0.5),
        0.75,
        0,
    )  # 0.8 N m at most, a wall touched
    again = after(command(2), command(2, torque=0.5), tick)  # the same number once more: dropped
    assert (again.ampere[2], again.damping, again.dropped) == (0.5, 0.25, 1)
    assert after(command(3), command(2, torque=0.5), tick).dropped == 1  # an older one
    assert after(command(2, answered=(answers + 1) % 2**32), tick).dropped == 1  # to a state that was never sent
    assert after(command(2, answered=(answers - 2) % 2**32), tick).dropped == 1  # or in another session
    cut = after(command(2), *silence)
    assert (cut.ampere, cut.tripped) == ((0.0, 0.0, 0.0), True)
    assert after(command(2), *silence, command(3), tick).tripped  # no reset in it
    armed = after(command(2), *silence, command(3, 1), tick)
    assert (armed.ampere[2], armed.tripped) == (0.5, False)
    replayed = after(command(2), *silence, command(3, 1), *silence, command(3, 1), tick)
    assert (replayed.ampere, replayed.tripped, replayed.dropped) == ((0.0, 0.0, 0.0), True, 1)
