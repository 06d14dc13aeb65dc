"""`python -m haptics`."""

import sys

from haptics.commands.cli import main

if __name__ == "__main__":
    sys.exit(main())
