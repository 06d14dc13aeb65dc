"""What each test file costs in processor time, child processes included: printed at the end of a run, dearest first.

A file of more than `DEAR_S` says what it costs, and why, in a line of its own at the end of its docstring:

    "60 s of processor: the one whole build that all tests share."

By that line it is also put in front of the others, so that no worker waits at the end for another's long file.
"""

from __future__ import annotations

import os
import re
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import Any

import pytest

DEAR_S = 20.0
SHOWN = 10
STATED = re.compile(r"^(\d+) s of processor: \S", re.MULTILINE)
WORKER = "processor_s"  # key of what a worker of pytest-xdist hands to the process that started it


def stated_s(docstring: str | None) -> float:
    """What a file's docstring says that it costs, in s; 0 where it says nothing."""
    found = STATED.search(docstring or "")
    return float(found[1]) if found else 0.0


def used_s() -> float:
    """Processor time of this process and of its children that have ended, s."""
    return sum(os.times()[:4])


def table(costs: Mapping[str, float], stated: Mapping[str, float]) -> list[str]:
    """The dearest files, one a line, and every file that costs something else than it says.

    Args:
        costs: File -> s, measured.
        stated: File -> s, of its docstring.
    """
    lines = []
    for rank, (name, cost) in enumerate(sorted(costs.items(), key=lambda one: -one[1])):
        said = stated.get(name, 0.0)
        wrong = ""
        if cost > DEAR_S and not said:
            wrong = "  <- its docstring is to say why"
        elif said and not said / 2.0 <= cost <= 2.0 * said:
            wrong = f"  <- its docstring says {said:.0f} s"
        if rank < SHOWN or wrong:
            lines.append(f"{cost:7.1f} s  {name}{wrong}")
    return lines


class Costs:
    """Measures each test file, in each worker, and prints all of them where the run was started."""

    def __init__(self) -> None:
        self._began, self._total = time.monotonic(), 0.0
        self._costs, self._stated = defaultdict[str, float](float), dict[str, float]()

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Puts the files that say what they cost first, the dearest before the others; all others keep their order."""
        for item in items:
            module = item.getparent(pytest.Module)
            self._stated[_file(item)] = stated_s(module.obj.__doc__ if module else None)
        items.sort(key=lambda item: -self._stated[_file(item)])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[Any]:
        """Adds what a test used, with the fixtures that it was the first to ask for, to its file."""
        before = used_s()
        try:
            return (yield)
        finally:
            self._costs[_file(item)] += used_s() - before

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Hands a worker's costs over; who started workers counts itself alone, as they count themselves."""
        starts_workers = bool(getattr(session.config.option, "numprocesses", 0))
        self._total += sum(os.times()[:2]) if starts_workers else used_s()
        if (output := getattr(session.config, "workeroutput", None)) is not None:
            output[WORKER] = (dict(self._costs), self._stated, self._total)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Takes a worker's costs; one that died has none."""
        costs, stated, total = getattr(node, "workeroutput", {}).get(WORKER, ({}, {}, 0.0))
        for name, cost in costs.items():
            self._costs[name] += cost
        self._stated.update(stated)
        self._total += total

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Prints them before pytest's own last line."""
        tests = sum(self._costs.values())
        load = ", ".join(f"{one:.1f}" for one in os.getloadavg())
        reported = f"tests: {time.monotonic() - self._began:.0f} s, {self._total:.0f} s of processor"
        terminalreporter.section("processor")
        terminalreporter.line(f"{reported} ({tests:.0f} in tests, the rest to start and collect); load {load}")
        usual = terminalreporter.config.option.markexpr == "not slow"  # of slow tests no docstring says anything
        for line in table(self._costs, self._stated if usual else self._costs):
            terminalreporter.line(line)


def _file(item: pytest.Item) -> str:
    return item.nodeid.partition("::")[0]
