"""`python -m optimizer`, or installed `delta-optimizer`."""

from typing import NoReturn

from delta_cad.common.command_line import run_program


def main() -> NoReturn:
    """Runs a command as a process."""
    run_program("optimizer.commands.cli")


if __name__ == "__main__":
    main()
