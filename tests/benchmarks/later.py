"""Lines of the budget that belong to capabilities to come: named, so that nobody takes their absence for a pass."""

LATER = (
    ("haptics", "controller tick in C", "<= 0.5 us median, <= 1 us p99"),
    ("peers", "coal", "beside ours in one run"),
)
ELSEWHERE = (("test command, warm environment", "<= 6 min", "`make test` prints its own time"),)
