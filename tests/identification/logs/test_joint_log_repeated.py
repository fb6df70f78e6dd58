"""Logs that stand twice among those given: refused by their rows, whatever their names."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.identification.log_faults.found_faults import prepared_logs
from lwr_dyn.identification.logs.joint_log import apart_from, digest_of, write_log
from tests.identification.plants import perturbed_plant, random_motion, simulated_log


@pytest.fixture(scope="module")
def pair(lwr, columns):
    plant, rng = perturbed_plant(columns, lwr, np.random.default_rng(1), 0.05), np.random.default_rng(2)
    return [simulated_log(plant, random_motion(lwr, 4.0, rng, rate=200.0), 0.1, rng, 1e-5) for _ in range(2)]


@pytest.fixture
def files(pair, tmp_path):
    for name, log in zip(("a.csv", "b.csv", "copy.csv", "copy.parquet"), [*pair, pair[0], pair[0]], strict=True):
        write_log(tmp_path / name, log)
    return tmp_path


@pytest.fixture
def identify(lwr_dyn_command):
    robot = ("lwr4plus", "--reading", "physical")
    return lambda name, *arguments: lwr_dyn_command("identify", name, *robot, *map(str, arguments))


def test_a_digest_is_of_what_was_measured(pair):
    one, other = pair
    assert digest_of(one) == digest_of(replace(one, source="elsewhere", t=one.t + 7.0))
    assert digest_of(one) != digest_of(other)
    touched = one.tau.copy()
    touched[-1, -1] = np.nextafter(touched[-1, -1], np.inf)
    assert digest_of(one) != digest_of(replace(one, tau=touched))
    assert digest_of(one) != digest_of(replace(one, t=one.t[:-1], q=one.q[:-1], tau=one.tau[:-1], dq=None))


def test_a_copy_is_left_out_and_said(files, pair):
    a, b = files / "a.csv", files / "b.csv"
    assert not prepared_logs([a, b]).errors
    for copy, said in (
        (files / "copy.csv", f"the same as those of {a}"), (files / "copy.parquet", f"the same as those of {a}"),
        (a, "given twice"),
    ):  # fmt: skip
        found = prepared_logs([a, b, copy])
        assert [log.source for log in found.logs] == [str(a), str(b)]
        (fault,) = found.errors
        assert str(fault) == f"{copy}: rows: {said}; needed: each recording once"
    assert apart_from(pair, [pair[1]], "which is fitted")[0] == [pair[0]]


@pytest.mark.slow
def test_validation_on_the_fitted_log_is_none(identify, files):
    code, out, err = identify("motion", files / "a.csv", files / "b.csv", "--validate", files / "copy.csv")
    assert code == 2
    assert "no fit has seen" not in out
    assert err.splitlines()[-1] == (
        f"lwr-dyn: {files / 'copy.csv'}: rows: the same as those of {files / 'a.csv'}, which is fitted; "
        "needed: logs that the fit does not see"
    )


@pytest.mark.slow
def test_one_log_with_and_without_the_load_says_nothing_of_a_load(identify, files):
    code, out, err = identify("payload", files / "a.csv", "--without", files / "copy.csv")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert f"the same as those of {files / 'a.csv'}, which is with the load; needed: logs without the load" in err


def test_friction_takes_each_log_once(identify, files):
    code, _, err = identify("friction", files / "a.csv", files / "copy.csv")
    assert code == 2
    assert f"{files / 'copy.csv'}: rows: the same as those of {files / 'a.csv'}; needed: each recording once" in err


def test_a_slowest_above_every_speed_is_named_as_the_cause(identify, files):
    code, out, err = identify("motion", files / "a.csv", "--slowest", "1e9")
    assert (code, out) == (2, "")
    assert "no joint is faster than --slowest 1e+09 (rad/s or m/s); needed: a slowest far below the speeds" in err
