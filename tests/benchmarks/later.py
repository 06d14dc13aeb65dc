"""Lines of the budget that belong to capabilities to come: named, so that nobody takes their absence for a pass."""

LATER = (("peers", "coal against FCL", "beside ours in one run"),)
ELSEWHERE = (("test command, warm environment", "<= 6 min", "`make test` prints its own time"),)
