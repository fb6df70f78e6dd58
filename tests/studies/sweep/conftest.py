"""What the tests of a study's file share."""

import pytest

from lwr_dyn.studies.sweep.read_study import read_study


@pytest.fixture
def read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def read_text(text):
        (tmp_path / "s.toml").write_text(text, encoding="utf-8")
        return read_study("s.toml")

    return read_text
