"""An arm and two runs of it."""

import pytest
from replayed import lagging_run

import lwr_dyn


@pytest.fixture(scope="session")
def arm():
    return lwr_dyn.load("lwr4plus")


@pytest.fixture(scope="session")
def two_runs(arm):
    return (lagging_run(arm, 0.04, "pd-gravity"), lagging_run(arm, 0.01, "inverse-dynamics"))
