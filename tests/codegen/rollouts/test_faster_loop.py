"""A long run of a law that compiles says which loop is faster; a short one, and one that none takes, say nothing."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts import compiled_loop
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.model.friction import symmetric
from lwr_dyn.model.run import Run
from lwr_dyn.simulation import simulate as module
from lwr_dyn.simulation.simulate import LONG, simulate
from tests.codegen.rollouts.beside import WHOLE, first_joints

STEPS = 60
WORDS = "loop: compiled is some 10 times as fast for such a run"


@pytest.fixture
def arm():
    return replace(first_joints(4), friction=WHOLE.friction)


@pytest.fixture(autouse=True)
def shorter(monkeypatch):
    """Runs of 60 steps count as long."""
    monkeypatch.setattr(module, "LONG", STEPS)


def _run(arm, law="pd-gravity", steps=STEPS, **options):
    controller = lwr_dyn.controller(law, arm) if isinstance(law, str) else law
    reference = lwr_dyn.reference("hold", arm, q=np.full(arm.n, 0.3), duration=1.0)
    return simulate(arm, controller, reference, duration=steps / 1000.0, **options)


def test_a_long_run_of_a_law_that_compiles_says_which_loop_is_faster(arm, tmp_path, monkeypatch):
    def compiles(plan):
        raise AssertionError("a hint needs no kernel")

    monkeypatch.setattr(compiled_loop, "whole_kernel", compiles)
    run = _run(arm)
    assert run.hint.startswith(WORDS)
    assert run.hint in repr(run)
    run.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz").hint == run.hint


def test_substeps_count(arm):
    assert _run(arm, steps=STEPS // 2, substeps=2).hint.startswith(WORDS)


def _stick(arm):
    return {"friction": [symmetric(0.05, 0.1)] * arm.n}


@pytest.mark.parametrize(
    ("law", "options"),
    [
        ("pd-gravity", lambda arm: {"steps": STEPS - 1}),
        (lambda t, q, dq, *_: 0.0 * q, lambda arm: {}),
        ("pd-gravity", lambda arm: {"loop": "compiled"}),
        ("pd-gravity", lambda arm: {"engine": "kernels"}),
        ("pd-gravity", lambda arm: {"continuous": True}),
        ("pd-gravity", lambda arm: {"method": "dop853"}),
        ("pd-gravity", _stick),
        ("pd-gravity", lambda arm: {"dq0": np.full(arm.n, 60.0), "q0": arm.upper - 1e-3}),
    ],
    ids=["short", "law of one's own", "compiled", "kernels", "continuous", "method", "stick", "stop"],
)
def test_nothing_is_said_where_no_other_loop_is_faster(arm, law, options):
    assert _run(arm, law, **options(arm)).hint == ""


def test_nothing_is_said_without_the_extra(arm, monkeypatch):
    def missing():
        raise MissingPackageError("llvmlite", "batch")

    monkeypatch.setattr(compiled_loop, "require_packages", missing)
    assert _run(arm).hint == ""


def test_signals_without_a_form_are_a_reason_too(arm, monkeypatch):
    controller = lwr_dyn.controller("pd-gravity", arm)
    monkeypatch.setattr(type(controller), "signals", {"mine": np.zeros(1)}, raising=False)
    assert _run(arm, controller).hint == ""


def test_the_run_is_the_same_and_the_law_keeps_what_it_has_learnt(arm):
    laws = [lwr_dyn.controller("adaptive", arm) for _ in range(2)]
    long, short = (_run(arm, law, steps) for law, steps in zip(laws, (STEPS, STEPS - 1), strict=True))
    assert long.hint
    assert not short.hint
    assert np.array_equal(long.q[:-1], short.q)
    name, estimate = next(iter(long.signals.items()))
    assert np.array_equal(laws[0].signals[name], estimate[-1])


@pytest.mark.slow
def test_the_command_says_it_in_one_line(lwr_dyn_command):
    move = ["--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "1,31,0,-60,0,30,0"]
    given = ["simulate", "lwr4plus", *move, "--controller", "pd-gravity"]
    code, _, err = lwr_dyn_command(*given)
    assert code == 0
    assert [line for line in err.splitlines() if WORDS in line] == [f"note: {WORDS}, apart from sampling its reference"]
    code, out, err = lwr_dyn_command(*given, "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["meta"]["hint"].startswith(WORDS)


@pytest.mark.slow
def test_fifty_seconds_at_a_kilohertz_are_long(arm, monkeypatch):
    monkeypatch.setattr(module, "LONG", LONG)
    reference = lwr_dyn.reference("hold", arm, q=np.full(arm.n, 0.3), duration=50.0)
    law = lwr_dyn.controller("pd-gravity", arm)
    assert simulate(arm, law, reference).hint.startswith(WORDS)
    assert simulate(arm, law, reference, duration=49.0).hint == ""
