"""Lines of the budget that belong to capabilities to come: named, so that nobody takes their absence for a pass."""

LATER = (
    ("haptics", "controller tick", "C: <= 0.5 us median, <= 1 us p99; Python: <= 20 us median"),
    ("haptics", "simulation, 1 kHz with 10 substeps", ">= 20x real time"),
    ("haptics", "peak memory of haptics", "<= 400 MB"),
    ("peers", "MuJoCo's step; coal", "beside ours in one run"),
)
ELSEWHERE = (("test command, warm environment", "<= 6 min", "`make test` prints its own time"),)
