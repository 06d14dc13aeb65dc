"""`python -m haptics`."""

from delta_cad.common.console import run_program

if __name__ == "__main__":
    run_program("haptics.commands.cli")
