"""`python -m delta_cad`."""

from delta_cad.common.console import run_program

if __name__ == "__main__":
    run_program("delta_cad.commands.cli")
