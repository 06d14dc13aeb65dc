"""Maps over the cube, whatever the values."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.mark.parametrize("values", [[1.0, 1.0], [1.0, 1.2], [1.0, 40.0], [-3.0, 40.0], [0.0, 0.0]])
@pytest.mark.parametrize("small", [True, False])
def test_a_map_is_drawn_whatever_its_range(values: list[float], small: bool) -> None:
    from haptics.feel.pictures import feel_map

    places = np.linspace(-10.0, 10.0, 5)
    field = np.linspace(*values, 75).reshape(3, 5, 5)
    figure = feel_map("what it is", "figure, N", places + 3.0, places, np.array([50.0, 60.0, 70.0]), field, small)
    figure.canvas.draw()
    *panels, bar = figure.axes
    assert [panel.get_title().split("\n")[0] for panel in panels] == [
        "bottom, z = 50.0 mm",
        "middle, z = 60.0 mm",
        "top, z = 70.0 mm",
    ]
    assert [line.get_xydata().tolist() for line in panels[0].lines] == [[[3.0, 0.0]]] * 2  # the cube's middle
    assert panels[2].get_title().endswith(f"to {values[1]:.4g}")
    assert bar.get_ylabel() == "figure, N"
    assert bar.yaxis_inverted() == small  # good is up
    low, high = sorted(bar.get_ylim())
    assert low <= values[0] <= values[1] <= high
