"""The small file, written where a test may change it, and once a module."""

import pytest

from tests.checks.engines.small_files import TWO


@pytest.fixture
def two(tmp_path):
    path = tmp_path / "two.urdf"
    path.write_text(TWO, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    path = tmp_path_factory.mktemp("two") / "two.urdf"
    path.write_text(TWO, encoding="utf-8")
    return path
