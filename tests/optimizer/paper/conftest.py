"""All published runs recomputed once, with a small GA: proofs and SQP do not depend on it."""

from __future__ import annotations

import pytest

from optimizer.paper.placed import PlacedStep, placed_step
from optimizer.paper.published import published_runs
from optimizer.paper.reproduction import ReproducedRun, Reproduction
from tests.committed import Shared


@pytest.fixture(scope="session")
def made() -> Reproduction:
    return Reproduction(population=12, generations=3)


@pytest.fixture(scope="session")
def runs(made: Reproduction, shared: Shared) -> list[ReproducedRun]:
    return shared.once("paper", lambda: made.recompute(published_runs()))


@pytest.fixture(scope="session")
def placed(made: Reproduction, shared: Shared) -> PlacedStep:
    return shared.once("placed", lambda: placed_step(made.gap, made.seed, made.seconds))
