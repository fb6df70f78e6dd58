"""`lwr-dyn parity` as a user types it."""

import pytest

from tests.checks.engines.small_files import TWO


@pytest.mark.slow
def test_one_engine_as_text(printed):
    out = printed("parity", "lwr4plus", "--reading", "computed", "--only", "pinocchio")
    assert "lwr4plus_computed.urdf: largest difference from ours over 20 random states" in out
    assert "ignored  0.016         2.5e-04  .srdf by loadRotorParameters" in out


@pytest.mark.slow
def test_json_has_every_feature(recorded, tmp_path):
    path = tmp_path / "two.urdf"
    path.write_text(TWO, encoding="utf-8")
    (model,) = recorded("parity", str(path), "--only", "yourdfpy")["models"]
    (engine,) = model["engines"]
    assert (model["file"], engine["mass"]) == ("two.urdf", 3.0)
    assert {"feature": "effort limits", "verdict": "recorded"}.items() <= engine["features"][3].items()


@pytest.mark.slow
def test_an_arm_without_masses_has_poses_and_limits(printed):
    out = printed("parity", "lwr4", "--only", "yourdfpy", "--markdown")
    assert "| file | feature | yourdfpy |" in out
    assert "| lwr4.urdf | links behind fixed joints | kept |" in out


def test_an_engine_that_is_not_there_is_named_with_how_to_install_it(refused, monkeypatch):
    monkeypatch.setattr("lwr_dyn.cli.parity.is_installed", lambda engine: False)
    err = refused("parity", "lwr4plus", "--only", "drake")
    assert err == "lwr-dyn: pydrake is not installed; install it with: pip install 'lwr_dyn[parity]'\n"


@pytest.mark.slow
def test_a_missing_engine_is_a_line_of_the_table(printed, monkeypatch):
    monkeypatch.setattr("lwr_dyn.checks.engines.survey.is_installed", lambda engine: engine == "yourdfpy")
    assert "drake: not installed: pip install drake" in printed("parity", "lwr4plus")


@pytest.mark.slow
def test_friction_that_no_format_holds_is_named(recorded):
    """WAM: the largest Coulomb level of a joint alone is 4.4748 N m."""
    words = recorded("parity", "wam7", "--only", "pinocchio")["models"][0]["unwritten"]
    assert words.startswith("friction that differs by direction is in none, up to ")
    assert float(words.split("up to ")[1].split(" N m")[0]) > 4.4


@pytest.mark.parametrize(
    "arguments",
    [("parity", "none.urdf"), ("parity", "lwr4plus", "--json", "--markdown"), ("parity", "x", "--only", "ode")],
)
def test_bad_input_gets_one_line(refused, arguments):
    refused(*arguments)
