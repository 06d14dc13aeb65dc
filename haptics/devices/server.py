"""The reference server: a board behind a UDP socket, with ticks as fast as the host answers or in real time."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable

from haptics.devices.board import Board
from haptics.devices.link import LARGEST, readable, udp_socket


def listen(host: str = "127.0.0.1", port: int = 0, *, allow_remote: bool = False) -> socket.socket:
    """A socket to serve on.

    Args:
        host: Numeric address.
        port: 0 for any that is free.
        allow_remote: Whether other machines may reach it.

    Returns:
        The socket; `getsockname()` has its port.

    Raises:
        ValueError: See `link.udp_socket`.
        OSError: The port is taken.
    """
    listening = udp_socket(host, allow_remote)
    try:
        listening.bind((host, port))
    except OSError:
        listening.close()
        raise
    return listening


def serve(
    board: Board,
    listening: socket.socket,
    *,
    patience: float,
    paced: bool = False,
    idle: float = 10.0,
    once: bool = False,
    clock: Callable[[], float] = time.monotonic,
    ready: Callable[[socket.socket, float], bool] = readable,
    stop: Callable[[], bool] = lambda: False,
) -> int:
    """Serves sessions until it is stopped, or nobody speaks.

    Args:
        board: The board.
        listening: Socket of the board; left open.
        patience: Longest wait for the COMMAND to a STATE before the next tick, s; the period of a paced board.
        paced: Whether each tick takes all of that time, as on a real board; otherwise the next follows the COMMAND.
        idle: Time without a session that opens or a COMMAND that is taken after which it ends, s.
        once: Whether it ends with the first session.
        clock: Grows by the second.
        ready: Waits so many seconds of that clock for a datagram, and says whether there is one.
        stop: Called at each tick; true ends the serving.

    Returns:
        Number of sessions.
    """
    peer, sessions, heard, due = None, 0, clock(), clock() + patience
    try:
        while not stop() and clock() - heard < idle:
            connected = board.connected
            wait = due - clock() if connected else idle - (clock() - heard)
            if connected and (wait <= 0.0 or (board.answered and not paced)):
                due = clock() + patience if wait < -patience or not paced else due + patience
                state = board.tick()
                if state is not None and peer is not None:
                    listening.sendto(state, peer)
                continue
            if not ready(listening, max(wait, 0.0)):
                continue
            data, sender = listening.recvfrom(LARGEST)
            taken = board.sessions + board.served
            reply = board.received(data, sender)
            if board.sessions + board.served > taken:
                heard = clock()
            if reply is not None:
                listening.sendto(reply, sender)
            if board.connected and (not connected or board.peer != peer):
                peer, due, sessions = board.peer, clock() + patience, sessions + 1
            if connected and not board.connected and once:
                break
    finally:
        farewell = board.farewell()
        if farewell is not None and peer is not None:
            listening.sendto(farewell, peer)
    return sessions
