"""A study: values of its runs, its digest, and counts that are not possible."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.studies.sweep.sampling import VariedParameter
from lwr_dyn.studies.sweep.sweep_study import SweepStudy

CENTRES = tuple(f"arm.com.{i}.{axis}" for i in range(1, 8) for axis in "xyz")
PARAMETERS = (
    VariedParameter("payload.mass", "uniform", ("payload.mass",), low=0.0, high=7.0),
    VariedParameter("payload.known", "fixed", ("payload.known",), values=(0.5,)),
    VariedParameter("arm.com", "normal", CENTRES, low=-0.01, high=0.01, deviation=0.005),
    VariedParameter("loop.delay", "choice", ("loop.delay",), values=(0.0, 1.0, 2.0)),
    VariedParameter("reading", "choice", ("reading",), values=("printed", "physical")),
)


@pytest.fixture
def study():
    return SweepStudy("s", "lwr4plus", "", ("pid",), "hold", runs=1500, parameters=PARAMETERS)


def test_values_of_runs_do_not_depend_on_the_chunks(study):
    whole = study.values(0, 1500)
    for first, stop in ((0, 1), (3, 1030), (1499, 1500)):
        part = study.values(first, stop)
        assert list(part) == ["payload.mass", "payload.known", "arm.com", "loop.delay", "reading"]
        for path, values in part.items():
            np.testing.assert_array_equal(values, whole[path][first:stop])


def test_values_follow_the_distributions(study):
    values = study.values(0, 1500)
    assert values["arm.com"].shape == (1500, 21)
    assert values["reading"].shape == (1500,)
    np.testing.assert_allclose(values["payload.mass"].mean(), 3.5, atol=0.02)
    assert (values["payload.known"] == 0.5).all()
    assert np.abs(values["arm.com"]).max() <= 0.01
    np.testing.assert_allclose(values["arm.com"].std(), 0.0044, atol=1e-4)  # 0.8796 of the deviation: cut at two
    assert [int((values["loop.delay"] == k).sum()) for k in range(3)] == pytest.approx([500] * 3, abs=5)
    assert set(values["reading"]) == {"printed", "physical"}


def test_each_number_is_drawn_by_itself(study):
    values = study.values(0, 1500)
    columns = [values["payload.mass"], *values["arm.com"].T, values["loop.delay"], values["reading"] == "printed"]
    correlations = np.corrcoef(np.array(columns, dtype=float)) - np.eye(len(columns))
    assert np.abs(correlations).max() < 0.1


def test_a_normal_distribution_without_ends_is_normal():
    free = VariedParameter("arm.mass", "normal", ("arm.mass",), mean=1.0, deviation=0.1)
    shares = np.array([0.0, 0.15865525393145707, 0.5, 0.9772498680518208])
    np.testing.assert_allclose(free.values_of(shares)[1:], [0.9, 1.0, 1.2], rtol=1e-12)
    assert np.isfinite(free.values_of(shares)).all()
    assert (free.lowest, free.highest) == pytest.approx((0.7, 1.3))


def test_the_digest_is_of_what_changes_results(study):
    assert replace(study, name="other", limits={"tip_max": 1e-3}, keep=9, text="# note").digest == study.digest
    more = VariedParameter("payload.mass", "uniform", ("payload.mass",), low=0.0, high=7.1)
    changed = [
        {"seed": 1}, {"chunk": 501}, {"controllers": ("pid:omega_n=20",)}, {"reading": "printed"},
        {"loop": {"rate": 500.0}}, {"tolerance": 1e-3}, {"sources": {"mine.py": "0"}}, {"task_options": {"q": [1.0]}},
        {"parameters": (more, *PARAMETERS[1:])}, {"robot": "lwr4"}, {"method": "random"}, {"quantiles": (0.5,)},
    ]  # fmt: skip
    digests = {replace(study, **change).digest for change in changed}
    assert len(digests | {study.digest}) == len(changed) + 1


def test_the_digest_of_a_stored_sweep_stays():
    """What a study leaves out is as it was when sweeps were stored, in the order in which they wrote it."""
    plain = SweepStudy("a", "arms/b.toml", "r", ("pid",), "hold")
    assert plain.digest == "a2627e8d625c916297bb90cf1608ce93aaed3686d68e2d64ec87daa251573009"
    assert (plain.runs, plain.keep, plain.count, plain.chunks, plain.limits) == (256, 3, 256, 1, {})
    assert [replace(plain, runs=x).chunks for x in (500, 501, 1000, 1001)] == [1, 2, 2, 3]
    options = {"to": np.array([1.0, 2.0]), "from": "folder/q.csv"}
    assert replace(plain, task_options=options).digest == replace(
        plain, task_options={"from": "elsewhere/q.csv", "to": [1.0, 2.0]}
    ).digest  # fmt: skip
    assert replace(plain, tip="tool").digest not in (plain.digest, replace(plain, tip="hand").digest)


@pytest.mark.parametrize(
    ("method", "more"), [("sobol", 3000), ("random", 3000), ("latin-hypercube", 3000), ("saltelli", 6 * 512)]
)
def test_the_first_of_more_runs_are_those_of_fewer(method, more, study):
    few = replace(study, method=method, runs=6 * 128)
    many = replace(few, runs=more)
    assert many.digest == few.digest
    for path, values in few.values(700, 768).items():
        np.testing.assert_array_equal(many.values(700, 768)[path], values)


def test_a_study_travels_to_another_process(study):
    there = pickle.loads(pickle.dumps(study))
    assert there.digest == study.digest
    np.testing.assert_array_equal(there.values(7, 9)["arm.com"], study.values(7, 9)["arm.com"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"runs": 0}, "runs: 0; allowed: a whole number from 1 to 10000000"),
        ({"chunk": 0}, "chunk: 0; allowed: a whole number from 1"),
        ({"keep": -1}, "keep: -1; allowed: a whole number from 0"),
        ({"seed": -1}, "seed: -1; allowed: a whole number from 0"),
        ({"method": "monte-carlo"}, "method: 'monte-carlo'; allowed: grid, sobol, latin-hypercube, random, saltelli"),
        ({"method": "latin-hypercube", "runs": 3_000_000}, r"24 numbers each; allowed: at most 1048576, or random"),
        ({"method": "saltelli"}, r"runs: 1500 by saltelli; allowed: 6 times a power of 2 .*, as 768 or 1536"),
    ],
)
def test_counts_that_are_not_possible_are_refused(change, words, study):
    with pytest.raises(OptionError, match=words):
        replace(study, **change)


def test_saltelli_counts_paths_and_a_grid_its_levels(study):
    assert replace(study, method="saltelli", runs=6 * 128).runs == 768
    levels = PARAMETERS[3:]
    assert replace(study, method="grid", parameters=levels, runs=6).runs == 6
    with pytest.raises(OptionError, match="6, the product of its levels"):
        replace(study, method="grid", parameters=levels)


def test_runs_outside_are_refused(study):
    for first, stop in ((0, 1501), (5, 5), (-1, 3)):
        with pytest.raises(OptionError, match="inside 0 to 1500"):
            study.values(first, stop)
