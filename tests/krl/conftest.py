"""The KR 30 HA, on which programs run here, and commands that take or refuse their input."""

import pytest

import lwr_dyn
from tests.cli.conftest import folder, printed, recorded, refused

__all__ = ["folder", "printed", "recorded", "refused"]


@pytest.fixture(scope="session")
def arm():
    return lwr_dyn.load("kr30ha")
