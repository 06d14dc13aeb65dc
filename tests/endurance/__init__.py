"""What hours of use do to a program in minutes: damaged files, kills, full disks; `python -m tests.endurance`."""
