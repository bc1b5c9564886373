"""Cases that take a second."""

from typing import Any

import granum
import pytest

SMALL: dict[str, Any] = {
    "grains": {"count": 60},
    "preparation": {"solid_fraction": "none", "unbalanced_force": 0.05},
    "shear": {"deviator_strain": 0.01, "inertial_number": 0.01},
    "recording": {"states": 4},
}


@pytest.fixture
def case() -> granum.Case:
    """A test of 60 grains."""
    return granum.Case(**SMALL)


@pytest.fixture(scope="session")
def tested() -> granum.Run:
    """The test of that case, in memory."""
    return granum.run(granum.Case(**SMALL))
