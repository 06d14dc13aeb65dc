"""`python -m delta_cad`, or installed `delta-cad`."""

from typing import NoReturn

from delta_cad.common.command_line import run_program


def main() -> NoReturn:
    """Runs a command as a process."""
    run_program("delta_cad.commands.cli")


if __name__ == "__main__":
    main()
