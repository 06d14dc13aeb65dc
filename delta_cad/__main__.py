"""`python -m delta_cad`."""

import sys

from delta_cad.commands.cli import main

if __name__ == "__main__":
    sys.exit(main())
