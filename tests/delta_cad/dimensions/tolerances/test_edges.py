"""Edges with a function: what a general break would do to them, by geometry, and that drawings state their own."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.edges import RIM_EDGE_MM, STUD_CORNER_MM, functional_edges
from delta_cad.dimensions.tolerances.machine import length_chains
from delta_cad.export.drawings.part.controlled import controlled
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of


def sunk_mm(ball_mm: float, hole_mm: float, broken_mm: float) -> float:
    """How far a ball sinks on a flat shoulder when the rim of its hole is broken: the circle it stands on is wider."""
    return sqrt(ball_mm**2 - hole_mm**2) / 2.0 - sqrt(ball_mm**2 - (hole_mm + 2.0 * broken_mm) ** 2) / 2.0


def test_a_rim_broken_as_all_edges_are_would_bring_the_balls_together() -> None:
    """Balls of 6 mm with holes of 2.55: 50.00 mm between them would be 49.68 to 49.90."""
    assert 50.0 - 2.0 * sunk_mm(6.0, 2.55, 0.3) == pytest.approx(49.68, abs=0.005)
    assert 50.0 - 2.0 * sunk_mm(6.0, 2.55, 0.1) == pytest.approx(49.90, abs=0.005)


def test_the_chain_counts_the_rim_as_it_is_drawn(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    (chain,) = (one for one in length_chains(d, "m") if one.name == "wrist along its axis")
    first, second = (link for link in chain.links if "edge" in link.what)
    hole = d.forearm.pin_diameter_mm + 0.05
    assert first.range[0] == pytest.approx(-sunk_mm(d.forearm.ball_diameter_mm, hole, RIM_EDGE_MM) / 2.0, rel=0.02)
    assert second.range == pytest.approx((0.0, -first.range[0]))
    assert (
        pytest.approx(0.025) == (hole - d.forearm.pin_diameter_mm) / 2.0 > STUD_CORNER_MM
    )  # the rim clears the corner


def test_lands_of_a_pinion_are_wider_than_their_edges_and_narrower_than_the_general_break(
    best_dimensions: Dimensions,
) -> None:
    c = best_dimensions.capstan
    assert c is not None
    land = c.run.pitch_mm - c.cable_diameter_mm
    ((lands,), worst) = functional_edges(best_dimensions)["pinion"], 0.3
    assert 2.0 * -lands.lower_mm < land < 2.0 * worst


def test_each_stands_on_its_part_s_drawing(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    parts, held = {part.number: part for part in best_assembly.parts}, controlled(best_dimensions)
    edges = functional_edges(best_dimensions)
    assert edges.keys() == {"joint_ball", "cross_bar", "upper_arm", "sector", "pinion"}
    turned = replace(best_dimensions, shaft=replace(best_dimensions.shaft, washer=None))
    assert functional_edges(turned).keys() - edges.keys() == {"shoulder_washer"}  # a bought one has the edges it has
    for number, own in edges.items():
        notes = features_of(parts[number], faces_of(parts[number].solid), held[number]).notes
        assert [text for key, text in notes.items() if key.startswith("edge")] == [edge.text for edge in own]
    assert "rim of the hole" in edges["joint_ball"][0].text
    assert "0/-0.02" in edges["joint_ball"][0].text


def test_a_direct_drive_has_those_of_its_balls_alone(direct_dimensions: Dimensions) -> None:
    assert functional_edges(direct_dimensions).keys() == {"joint_ball", "cross_bar"}
