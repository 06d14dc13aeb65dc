"""The codes of faults: numbers, names and texts."""

from haptics.control.supervisor import supervisor as compiled
from haptics.control.supervisor.faults import (
    EXTERNAL,
    LATCHING,
    TABLE,
    FaultCode,
    Reaction,
    Severity,
    findings,
    mask,
)


def test_codes_keep_their_numbers_and_the_compiled_bits_their_names() -> None:
    """Logs, boards and the C header keep the numbers: a new code gets a new one, wherever it stands in the list."""
    numbers = (
        "ANGLE_INVALID ANGLE_JUMP ANGLE_FROZEN FROZEN_SUSPECTED CLOCK_INVALID TICK_LATE DEADLINE_MISSED EDGE_LEFT "
        "EDGE_FAR JOINT_RANGE NOT_CLOSED SINGULAR SINGULAR_NEAR OVERSPEED MOTOR_WARM MOTOR_HOT COMMAND_STALE "
        "COMMAND_INVALID RAMP_HELD ENERGY_LIMITED ENERGY_SPENT ORDER WATCHDOG DEVICE_LOST EMERGENCY_STOP"
    )
    assert [FaultCode[name] for name in numbers.split()] == list(range(1, 26))
    for code in set(FaultCode) - set(findings(EXTERNAL)):
        assert getattr(compiled, f"_{code.name}") == code.bit


def test_every_code_is_distinguished_and_reported_about() -> None:
    assert sorted(TABLE) == sorted(FaultCode)
    assert len({about.text for about in TABLE.values()}) == len(FaultCode)
    assert mask(FaultCode) < 2**53, "the memory keeps the bits in a float"
    for fault, about in TABLE.items():
        assert findings(fault.bit) == (fault,)
        assert (about.severity is Severity.FAULT) == bool(fault.bit & LATCHING)
        assert (about.severity is Severity.WARNING) == (about.reaction in (Reaction.NONE, Reaction.FADE))
        assert about.cleared
