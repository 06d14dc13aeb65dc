"""Runs a command and says what it took: clock and processor, child processes included.

`python3 scripts/timed.py linters make lint`
"""

import os
import subprocess
import sys
import time

began = time.monotonic()
code = subprocess.run(sys.argv[2:], close_fds=False).returncode
processor_s = sum(os.times()[2:4])
print(f"{sys.argv[1]}: {time.monotonic() - began:.0f} s, {processor_s:.0f} s of processor", flush=True)
sys.exit(code if code >= 0 else 1)
