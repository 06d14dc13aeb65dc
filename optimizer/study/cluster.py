"""Many sets of requirements at once on a Dask scheduler: every set is a task, every result a row, kept as it arrives.

A set's row depends on the set alone, so that neither the number of workers nor their order shows in the atlas, only in
the seconds. A task whose worker dies is given to another one. Dask is loaded in the functions that need it.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict
from multiprocessing import resource_tracker
from queue import Empty, SimpleQueue
from tempfile import TemporaryDirectory
from threading import Thread
from time import process_time
from typing import TYPE_CHECKING, Any, NamedTuple

from optimizer.study.grid import MACHINES, AtlasRow, Grid, Set

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

CONNECT_S = 10  # longest wait for a scheduler to answer and for its first worker to be there
_RETRIES = 2  # further tries of a task that raised; one whose worker died the scheduler gives away three times
_LOOK_S = 0.2  # time between two looks at Ctrl-C
# One thread in each process: the processes are the parallelism.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class ClusterError(RuntimeError):
    """No cluster to work on; the message says why."""


class Failure(NamedTuple):
    """A set that came to no row.

    Attributes:
        place: Index of the set.
        reason: In one line.
    """

    place: int
    reason: str


def solve(one: Mapping[str, Any]) -> AtlasRow:
    """Solves one set; what runs on the workers.

    Returns:
        Plain data: `index`, `inputs`, `method`, `seed`; `feasible`; `steps`, the records of the steps' results;
        `conflict`, names of the constraints that cannot be met together, with `conflict_step` and `message`; processor
        `seconds`; of a brief also `machine` and `design`, as `machine_row` has them.
    """
    row: AtlasRow = {name: one[name] for name in ("index", "inputs", "method", "seed")}
    row |= {"feasible": False, "steps": [], "conflict": [], "conflict_step": None, "message": ""}
    if one["method"] == MACHINES:
        from optimizer.study.atlas import machine_row

        start = process_time()
        return row | machine_row(one) | {"seconds": process_time() - start}
    from optimizer.problem.requirements import requirements_from_dict
    from optimizer.synthesis.infeasible import InfeasibleError
    from optimizer.synthesis.three_step import Run

    start = process_time()
    given = requirements_from_dict(one["requirements"])
    sizes = {"population": one["population"], "generations": one["generations"]}
    try:
        results = Run(given, one["method"], one["seed"], tuple(one["steps"]), **sizes).results()
    except InfeasibleError as error:
        row |= {"conflict": list(error.conflict), "conflict_step": error.step, "message": str(error)}
    else:
        row |= {"feasible": all(r.feasible for r in results), "steps": [r.record() for r in results]}
        row["message"] = results[-1].advice
    return row | {"seconds": process_time() - start}


def collect(
    client: Client,
    sets: Iterable[Set],
    take: Callable[[AtlasRow], None],
    stop: Callable[[], bool] = bool,
) -> list[Failure]:
    """Solves sets on a cluster.

    Args:
        client: Client of the cluster.
        sets: What to solve.
        take: Given each row as it arrives, in any order.
        stop: Called between arrivals; True gives up what is not done.

    Returns:
        The sets that came to no row for another reason than `stop`, by their index.
    """
    arrived: SimpleQueue[tuple[int, Future]] = SimpleQueue()
    waiting: dict[int, Future] = {}
    for one in sets:
        future = client.submit(solve, asdict(one), pure=False, retries=_RETRIES, priority=-one.index)
        waiting[one.index] = future
        future.add_done_callback(lambda done, index=one.index: arrived.put((index, done)))
    failed = []
    while waiting and not stop():
        try:
            index, future = arrived.get(timeout=_LOOK_S)
        except Empty:
            continue
        del waiting[index]
        if future.status == "finished":
            take(future.result())
        else:
            failed.append(Failure(index, _reason(future)))
    client.cancel(list(waiting.values()))
    return sorted(failed)


def _reason(future: Future) -> str:
    """Says why a task came to nothing, in one line."""
    if future.status != "error":
        return "the scheduler was lost"
    error = future.exception()
    kind, text = type(error).__name__, " ".join(str(error).split())
    return "its workers died again and again" if kind == "KilledWorker" else f"{kind}: {text}"


@contextmanager
def local_cluster(workers: int) -> Iterator[Client]:
    """Starts processes of this machine, one thread each, without Dask's own page and with nothing open to the network.

    Yields:
        Its client.

    Raises:
        ClusterError: They could not be started.
    """
    from dask import config
    from distributed import Client, LocalCluster

    pinned = {f"distributed.nanny.pre-spawn-environ.{name}": 1 for name in THREADS}
    with ExitStack() as stack:
        stack.enter_context(_quiet())
        stack.enter_context(config.set({"distributed.worker.multiprocessing-method": "spawn", **pinned}))
        folder = stack.enter_context(TemporaryDirectory(prefix="atlas-", ignore_cleanup_errors=True))
        # the resource tracker would unblock SIGINT again where it is started by the way; it is to clean up after a
        # command that is interrupted without a word
        sys.warnoptions.append("ignore:resource_tracker")
        resource_tracker.ensure_running()
        sys.warnoptions.pop()

        def start() -> LocalCluster:
            return LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",  # None would ask for port 8787 and warn where it is taken
                scheduler_kwargs={"dashboard": False},
                memory_limit=0,  # no watch over it: a worker needs 300 MB
                local_directory=folder,
                silence_logs=logging.CRITICAL,
            )

        try:
            cluster = _deaf(start)
            stack.enter_context(cluster)
            client = stack.enter_context(Client(cluster, set_as_default=False))
        except (OSError, RuntimeError, TimeoutError) as error:
            raise ClusterError(f"no workers could be started: {' '.join(str(error).split())}") from None
        stack.callback(_end, cluster)
        yield client


def _deaf(start: Callable[[], LocalCluster]) -> LocalCluster:
    """Starts a cluster whose threads and processes inherit that SIGINT is blocked: the command alone hears Ctrl-C.

    They are started by a thread of their own, so that the command hears it meanwhile, too.
    """
    came: SimpleQueue[LocalCluster | Exception] = SimpleQueue()

    def work() -> None:
        if hasattr(signal, "pthread_sigmask"):  # not on Windows
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            came.put(start())
        except Exception as error:
            came.put(error)

    Thread(target=work, daemon=True).start()
    cluster = came.get()
    if isinstance(cluster, Exception):
        raise cluster
    return cluster


def _end(cluster: LocalCluster) -> None:
    """Ends the processes of a cluster whose rows are taken or given up; asked, a busy one would answer in seconds."""
    for nanny in cluster.workers.values():
        with suppress(OSError):
            os.kill(nanny.pid, getattr(signal, "SIGKILL", signal.SIGTERM))


@contextmanager
def given_cluster(address: str) -> Iterator[Client]:
    """Connects to a cluster that is already there; its workers need this package.

    Args:
        address: Address of its scheduler, such as "tcp://10.0.0.5:8786".

    Yields:
        Its client.

    Raises:
        ClusterError: No scheduler answers there, or it has no worker.
    """
    from distributed import Client

    with _quiet():
        try:
            client = Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TypeError, ImportError) as error:
            words = " ".join(str(error).split())
            raise ClusterError(f"no scheduler answers at {address}: {words}") from None
        with client:
            try:
                client.wait_for_workers(1, timeout=CONNECT_S)
            except TimeoutError:
                raise ClusterError(f"the scheduler at {address} has no worker") from None
            yield client


def key_of(grid: Grid) -> dict[str, Any]:
    """Gives the key of an atlas's checkpoint: what makes it the same atlas."""
    return {"atlas": 2, "sha256": grid.sha256, "sets": len(grid.sets)}


@contextmanager
def _quiet() -> Iterator[None]:
    """Silences Dask's own messages on stderr: what matters comes back in rows and failures."""
    import distributed  # its import sets the levels

    logger = logging.getLogger(distributed.__name__)
    before, logger.propagate = logger.propagate, False
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(level)
        logger.propagate = before


def workers_here() -> int:
    """Counts the processes that this machine has cores for; those that this process may use, where the system says."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
