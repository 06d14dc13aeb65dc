"""`python -m tests.delta_cad.faults [WORD ...]`: plants each fault, or those with a word in it; says what refuses it.

Exit code 1 if a fault is missed that `MISSES` does not name, or one is caught that it does, or the sound machine is
refused.
"""

from __future__ import annotations

import sys
from itertools import chain
from time import perf_counter

from tests.delta_cad.faults.misses import excuse
from tests.delta_cad.faults.planting import faults, machines, sound
from tests.delta_cad.faults.refusing import Refusing


def main(words: list[str]) -> int:
    """Plants the faults that have one of the words in their name, or all."""
    wrong: list[str] = []
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
            by, why = refusing.first_refusal(fault.assembly), excuse(fault.name)
            total, caught = total + 1, caught + (by is not None)
            if (by is None) != (why is not None):
                wrong.append(fault.name)
            told = by or f"MISSED{f': {why}' if why else ''}"
            print(f"{fault.name}: {told} ({perf_counter() - start:.1f} s)", flush=True)
    print(f"{caught} of {total} faults caught, {100.0 * caught / max(total, 1):.1f} %")
    print(f"not as expected: {'; '.join(wrong)}" if wrong else "those missed are the ones that are named")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
