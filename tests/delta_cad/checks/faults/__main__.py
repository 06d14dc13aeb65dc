"""`python -m tests.delta_cad.checks.faults [WORD ...]`: plants faults, all or those with a word; says what refuses.

What goes missing without a reason is looked at once more with nothing left out. Exit code 1 if a fault is missed that
`MISSES` does not name, or all are caught that one of its patterns names, or the sound machine is refused.
"""

from __future__ import annotations

import sys
from itertools import chain
from time import perf_counter

from tests.delta_cad.checks.faults.misses import MISSES, excuse
from tests.delta_cad.checks.faults.planting import faults, machines, sound
from tests.delta_cad.checks.faults.refusing import Refusing


def main(words: list[str]) -> int:
    """Plants the faults that have one of the words in their name, or all."""
    wrong: list[str] = []
    named, needed = set[str](), set[str]()
    caught = total = 0
    for whole, design, numbers in machines():
        planted = faults(numbers, others=whole is sound(), whole=whole)
        chosen = (fault for fault in planted if not words or any(word in fault.name for word in words))
        if (first := next(chosen, None)) is None:
            continue
        refusing = Refusing(whole, design)
        if refused := refusing.first_refusal(whole):
            print(f"the sound machine {whole.name} is refused: {refused}")
            return 1
        for fault in chain([first], chosen):
            start = perf_counter()
            by, pattern = refusing.first_refusal(fault.assembly), excuse(fault.name, whole.name)
            if by is None and pattern is None:
                by = refusing.first_refusal(fault.assembly, shared=False)
            total, caught = total + 1, caught + (by is not None)
            if pattern is not None:
                named.add(pattern)
                needed |= {pattern} if by is None else set()
            elif by is None:
                wrong.append(fault.name)
            reported = by or f"MISSED{f': {MISSES[pattern]}' if pattern else ''}"
            print(f"{fault.name}: {reported} ({perf_counter() - start:.1f} s)", flush=True)
    print(f"{caught} of {total} faults caught, {100.0 * caught / max(total, 1):.1f} %")
    wrong += [f"nothing is missed by {pattern!r}" for pattern in sorted(named - needed)]
    print(f"not as expected: {'; '.join(wrong)}" if wrong else "those missed are the ones that are named")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
