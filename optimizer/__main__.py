"""`python -m optimizer`."""

from delta_cad.common.console import run_program

if __name__ == "__main__":
    run_program("optimizer.commands.cli")
