"""`python -m haptics`, or installed `delta-haptics`."""

from typing import NoReturn

from delta_cad.common.command_line import run_program


def main() -> NoReturn:
    """Runs a command as a process."""
    run_program("haptics.commands.cli")


if __name__ == "__main__":
    main()
