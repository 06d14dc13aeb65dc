"""`python -m haptics`."""

import sys

from haptics.cli import main

if __name__ == "__main__":
    sys.exit(main())
