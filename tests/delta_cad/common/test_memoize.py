"""What is found once is found again, and goes with the object."""

import gc

from delta_cad.common.memoize import memoize


class Thing:
    """Equal to all of its kind, as shapes of the CAD kernel are."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Thing)

    def __hash__(self) -> int:
        return 1


def test_each_object_is_required_once_by_identity_and_forgotten_with_it() -> None:
    required: list[int] = []

    @memoize
    def find(of: Thing) -> int:
        required.append(id(of))
        return len(required)

    one, other = Thing(), Thing()
    assert [find(one), find(other), find(one), find(other)] == [1, 2, 1, 2]
    del one
    gc.collect()
    for count in range(20):  # one of these takes the place of the first in memory
        assert find(Thing()) == 3 + count
