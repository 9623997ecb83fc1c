"""What the tests share."""

import ocmc
import pytest


@pytest.fixture(scope="session")
def study():
    """A study with short cycles, so that tests are quick."""
    return ocmc.Study("field-truck").set("mission.length_m", 5000)


@pytest.fixture(scope="session")
def run(study):
    return study.run(cycles=300)
