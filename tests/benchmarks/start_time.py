"""How fast the commands answer `--help`, and what an import of the package costs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec

from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import python, succeeded

SUBJECT = "start"
ROUNDS = 7
HELP_S = 0.5
PACKAGES = ("delta_cad", "optimizer", "haptics")  # those that have commands


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    commands: dict[str, tuple[str, ...]] = {}
    for package in (name for name in PACKAGES if find_spec(f"{name}.__main__")):
        for words in ((), *((name,) for name in _subcommands(package))):
            arguments = (package, *words, "--help")
            commands[f"python -m {' '.join(arguments)}"] = ("-m", *arguments)
    say(f"{len(commands)} commands' --help, {ROUNDS} rounds")
    lines = {**commands, "bare interpreter": ("-c", "")}
    times: dict[str, list[float]] = {name: [] for name in lines}
    for _ in range(ROUNDS):
        for name, arguments in lines.items():
            times[name].append(succeeded(python(*arguments)).wall_s)
    return [of_repeats(SUBJECT, name, times[name], "s", HELP_S if name in commands else None) for name in lines]


def _subcommands(package: str) -> list[str]:
    """The subcommands that a package's parser knows."""
    parser: Callable[[], argparse.ArgumentParser] = import_module(f"{package}.commands.cli").parser
    return [
        name
        for action in parser()._actions
        if isinstance(action, argparse._SubParsersAction)
        for name in action.choices
    ]
