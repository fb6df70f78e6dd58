"""A task under several readings: what is compared, which conclusions follow, which input is refused."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.checks.sensitivity.analysis import (
    error_table,
    errors_text,
    gains_table,
    gravity_table,
    notes,
    sensitivity,
    survival,
)
from lwr_dyn.checks.sensitivity.closed_loops import (
    SAFE,
    Conclusion,
    closed_loops,
    conclusions,
    shared_poses,
    statics_of,
)
from lwr_dyn.checks.sensitivity.study_tasks import PublishedClaim, controller_of, simulated_task
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from lwr_dyn.design.sampled_stability import stability_at
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.model.arm import arm_with_scaled_inertia
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.trajectory.references.joint_moves import point_to_point

PD, INVERSE = "PD + gravity, damping on dq", "inverse dynamics with feed-forward"
RATE = 250.0
"""[Hz] Inverse dynamics holds at it, PD at five times as much."""


@pytest.fixture(scope="module")
def arms():
    """The LWR 4+ with its rotors as built and its wrist held: in the default reading PD is sampled at 11 kHz."""
    arm = lwr_dyn.load("lwr4plus", "physical", lock=dict.fromkeys(("joint_5", "joint_6", "joint_7"), 0.5))
    return {"true": arm, "heavy": arm_with_scaled_inertia(arm, 1.1)}


@pytest.fixture(scope="module")
def result(arms):
    return sensitivity(arms, "joint-move", rate=RATE, poses=50)


def test_gravity_and_inertia_scale_with_the_masses(result):
    true, heavy = result.statics["true"], result.statics["heavy"]
    assert heavy.gravity == pytest.approx(1.1 * true.gravity, rel=1e-9, abs=1e-12)
    assert heavy.gravity_off(true) == pytest.approx(0.1 * np.abs(true.gravity).max(axis=0), rel=1e-6, abs=1e-12)
    assert heavy.gains.Kp == pytest.approx(2500.0 * heavy.b)
    assert heavy.gains.Kd == pytest.approx(100.0 * heavy.b)
    record = result.document.record()
    assert (record["rate"], record["poses"], record["readings"]) == (RATE, 50, ["true", "heavy"])
    for name, one in result.statics.items():
        assert {key: list(values) for key, values in record["statics"][name].items()} == {
            "gravity_largest": np.abs(one.gravity).max(axis=0).tolist(), "b": one.b.tolist(),
            "Kp": one.gains.Kp.tolist(), "Kd": one.gains.Kd.tolist(),
            "gravity_difference": np.abs(one.gravity - true.gravity).max(axis=0).tolist(),
        }  # fmt: skip


def test_tables_have_the_numbers_of_each_reading_beside_those_of_the_first(result):
    true, heavy = result.statics["true"], result.statics["heavy"]

    def cells(values):
        return [f"{x:.4g}" if abs(x) > 1e-12 else "0" for x in values]

    table = gravity_table(result)
    assert (table.title, table.cells) == ("gravity torques at 50 poses [N m (N)]", (
        ("true", "largest |g|", *cells(np.abs(true.gravity).max(axis=0))),
        ("heavy", "largest |g|", *cells(np.abs(heavy.gravity).max(axis=0))),
        ("heavy", "largest difference to true", *cells(heavy.gravity_off(true))),
    ))  # fmt: skip
    table, off = gains_table(result), [f"{x:+.2f}%" for x in 100 * (heavy.b / true.b - 1.0)]
    of_each = [[(name, what, *cells(x)) for what, x in (("b", s.b), ("Kp", s.gains.Kp), ("Kd", s.gains.Kd))]
               for name, s in result.statics.items()]  # fmt: skip
    assert table.cells == (*of_each[0], *of_each[1], ("heavy", "off true", *off))
    assert table.title.endswith("inertia b = max B_ii over the joint box [kg m^2 (kg)], and gains 2500 b, 100 b")
    small = {"x": replace(true, gravity=np.array([[1e-12, -1.1e-12, 0.0, -12345.678]]))}
    assert gravity_table(replace(result, statics=small)).cells[0][2:] == ("0", "1.1e-12", "0", "1.235e+04")
    assert errors_text(result).startswith("8 runs of 4 s at 250 samples a second or more: RMS error of the tip (rigid")
    assert survival(result).cells == tuple((c.text, c.verdict()) for c in result.conclusions)


def test_a_controller_that_knows_its_plant_does_best(result):
    """Rows are models and columns plants: the arm droops where the model is lighter than the plant."""
    tips = result.tip_rms_mm(INVERSE)
    assert (np.argmin(tips, axis=0).tolist(), tips[0, 1] > 10 * tips[0, 0]) == ([0, 1], True)
    assert np.isfinite(result.tip_rms_mm(PD)).all()
    runs = {(o.model, o.plant): o for o in result.runs if o.controller == INVERSE}
    light, heavy = (runs[key].metrics.position_mrad.mean for key in (("true", "heavy"), ("heavy", "true")))
    assert np.sign(light[1]) == -np.sign(heavy[1])
    assert result.worst_mrad(INVERSE)[0, 1] == runs["true", "heavy"].worst_mrad
    for errors, one in ((one.metrics.position_mrad, one) for one in result.runs):
        assert one.worst_mrad == np.abs([errors.max, errors.min]).max()


def test_a_loop_that_holds_is_sampled_as_wanted_and_another_is_continuous(arms):
    """PD would need `SAFE` times the least rate that holds; both take the steps of the task."""
    arm, model, statics = arms["true"], arms["heavy"], statics_of(arms, 3, 0, 50.0, 1.0)
    study = simulated_task(arm, "joint-move")
    start = study.reference.waypoints[0]
    move = point_to_point(arm, np.array([start, start + 0.05]), [0.1])
    study = replace(study, task=replace(study.task, substeps=2), reference=move)
    runs = {(o.controller, o.model, o.plant): o for o in closed_loops(arms, study, statics, RATE)}
    for choice, more in zip(study.task.controllers, ({"continuous": True, "loop": "stiff"}, {}), strict=True):
        law, found = controller_of(model, choice, statics["heavy"].b), runs[study.labels[choice.id], "heavy", "true"]
        run = lwr_dyn.simulate(model, law, move, plant=arm, rate=RATE, substeps=2, **more)
        assert found.metrics.to_json() == metrics(run, arm).to_json()
        q = move.sample(np.linspace(0.0, 0.1, 50)).q
        least = stability_at(RestingLoop.of(dynamics_of(arm), law, q), Sampling(RATE), q).least_rate
        assert found.rate == (RATE * np.ceil(SAFE * least / RATE) if more else RATE)


def test_conclusions_are_computed(result):
    by_text = {c.text: c for c in result.conclusions}
    better = by_text[f"{INVERSE} tracks better than {PD} (RMS of the tip)"]
    tips = result.tip_rms_mm(INVERSE) < result.tip_rms_mm(PD)
    assert better.holds == {(x, y): tips[i, j] for i, x in enumerate(result.names) for j, y in enumerate(result.names)}
    text = "gains from max B_ii are those of true within"
    gains = [(c.text, c.holds) for c in result.conclusions[-2:]]
    assert gains == [(f"{text} 1%", {("heavy",): False}), (f"{text} 5%", {("heavy",): False})]


def test_a_limit_that_is_met_is_kept_and_an_unknown_one_says_nothing(result, monkeypatch):
    """Of both laws, one figure each at its bound and one beyond; where a run failed, what needs it is open."""
    pd, inverse = result.runs[0], result.runs[4]
    order = "inverse tracks better than PD (RMS of the tip)"
    limits = [
        f"{what} keep to their limits under {name}" for name in ("PD", "inverse") for what in ("torques", "speeds")
    ]

    def judged(of_pd, of_inverse):
        runs = [replace(one, metrics=more and replace(one.metrics, **more))
                for one, more in ((pd, of_pd), (inverse, of_inverse))]  # fmt: skip
        found = conclusions(result.study, runs, result.statics)[:-2]
        return {c.text.replace(PD, "PD").replace(INVERSE, "inverse"): c.holds["true", "true"] for c in found}

    free = {"torque_use": np.full(4, np.nan), "speed_use": np.full(4, np.nan), "saturated_s": np.full(4, np.nan)}
    kept = {
        "torque_use": np.array([np.nan, 1, 0, 0]),
        "speed_use": np.array([np.nan, 1, 0, 0]),
        "saturated_s": np.zeros(4),
    }
    over = kept | {"speed_use": np.array([0, 0, 0, 1.001]), "saturated_s": np.array([0, 1e-3, 0, 0])}
    assert judged(free, free | {"tip_rms_mm": pd.tip_rms_mm}) == {order: False}
    assert judged(free | {"tip_rms_mm": 2.0}, kept | {"tip_rms_mm": 1.0}) == {order: True} | dict.fromkeys(limits, True)
    assert judged(None, over) == {order: None} | dict(zip(limits, [None, None, False, False], strict=True))
    assert judged(free, None) == {order: None}
    monkeypatch.setattr("lwr_dyn.checks.sensitivity.closed_loops.SAME_GAINS", (0.25, 0.5))
    inertias = {"true": [4.0, 4.0], "more": [5.0, 4.0], "less": [4.0, 2.0]}
    statics = {name: replace(result.statics["true"], b=np.array(b)) for name, b in inertias.items()}
    gains = conclusions(result.study, result.runs, statics)[-2:]
    assert [[*c.holds.values()] for c in gains] == [[True, False], [True, True]]


def test_largest_joints_are_a_proposition(result):
    claims = (
        PublishedClaim("as published", "", "PD", _two_largest(result), "max"),
        PublishedClaim("never", "", "PD", tuple({0, 1, 2, 3} - {*_two_largest(result)}), "max"),
    )
    study = replace(result.study, task=replace(result.study.task, claims=claims))
    by_text = {c.text: c for c in conclusions(study, result.runs, result.statics)}
    assert by_text[f"as published under {PD}"].holds["true", "true"] is True
    assert not by_text[f"never under {PD}"].survives


def _two_largest(result):
    run = next(o for o in result.runs if (o.controller, o.model, o.plant) == (PD, "true", "true"))
    return tuple(np.argsort(-np.abs(run.metrics.position_mrad.max))[:2].tolist())


PAIRS = [(a, b) for a in "xy" for b in "xy"]


@pytest.mark.parametrize(
    ("holds", "verdict", "share"),
    [
        (dict.fromkeys(PAIRS, True), "holds under all 4 pairs", 1.0),
        (dict.fromkeys(PAIRS, False), "holds under none of 4 pairs", 0.0),
        ({**dict.fromkeys(PAIRS, True), ("x", "y"): None}, "fails for x on y (3 of 4 hold)", 0.75),
        ({**dict.fromkeys(PAIRS, False), ("y", "y"): True}, "holds only for y on itself (1 of 4 hold)", 0.25),
        ({("x",): True, ("y",): False}, "holds only for x (1 of 2 hold)", 0.5),
        ({("x",): True, ("y",): True}, "holds under all 2 readings", 1.0),
        ({("x",): False, ("y",): None}, "holds under none of 2 readings", 0.0),
        ({("x",): True}, "holds under the one reading", 1.0),
        ({("x",): False}, "fails under the one reading", 0.0),
    ],
)
def test_verdicts_in_words(holds, verdict, share):
    one = Conclusion("", holds)
    assert (one.verdict(), one.survives, one.share) == (verdict, share == 1.0, share)


@pytest.mark.slow
def test_a_loop_that_would_chatter_is_sampled_faster():
    """The physical wrist has 90 times the inertia that the computed one has: its Kd is far too strong there."""
    arms = {name: lwr_dyn.load("lwr4plus", name) for name in ("computed", "physical")}
    study = simulated_task(arms["computed"], "joint-move")
    move = point_to_point(arms["computed"], study.reference.waypoints[:2], [0.5])
    statics = statics_of(arms, 5, 0, 50.0, 1.0)
    runs = {
        (o.model, o.plant): o
        for o in closed_loops(arms, replace(study, reference=move), statics, 1000.0)
        if o.controller == PD
    }
    assert runs["computed", "physical"].rate == 1000.0
    assert runs["physical", "computed"].rate > 5000.0
    assert runs["physical", "computed"].worst_mrad < 2 * runs["physical", "physical"].worst_mrad


@pytest.fixture
def narrow(arms):
    """The arm beside one whose first joint has less room."""
    arm = arms["true"]
    limits = (replace(arm.limits[0], lower=1.0, upper=2.0), *arm.limits[1:])
    return {"true": arm, "narrow": replace(arm, limits=limits)}


def test_a_simulation_that_fails_is_reported(narrow):
    done = []
    result = sensitivity(narrow, "joint-move", rate=RATE, poses=5, progress=done.append)
    assert done == [k / 8 for k in range(1, 9)]
    faults = {(o.model, o.plant): o.fault for o in result.runs if o.controller == PD}
    assert (faults["narrow", "true"], "joint_1" in faults["true", "narrow"]) == ("", True)
    assert np.isnan(result.tip_rms_mm(PD)[0, 1])
    assert next(iter(result.conclusions)).holds["true", "narrow"] is None


def test_poses_lie_in_the_box_that_all_allow(narrow):
    q = shared_poses(narrow, 100, 0)
    assert 1.0 <= q[:, 0].min() < 1.1 < 1.9 < q[:, 0].max() <= 2.0
    assert np.array_equal(q, shared_poses(narrow, 100, 0))
    first, other = narrow.values()
    for upper in (first.lower[0], first.lower[0] - 1.0):  # ranges that touch or lie apart
        apart = replace(other, limits=(replace(first.limits[0], lower=-9.0, upper=upper), *first.limits[1:]))
        assert np.array_equal(
            shared_poses({"a": first, "b": apart}, 9, 0), shared_poses({"a": first, "b": first}, 9, 0)
        )
    free = replace(first, limits=(replace(first.limits[0], lower=None, upper=None), *first.limits[1:]))
    assert np.abs(shared_poses({"a": free, "b": free}, 200, 0)[:, 0]).max() == pytest.approx(np.pi, rel=0.05)


@pytest.mark.slow
def test_readings_of_the_lwr_differ_in_gravity_by_the_copied_centre_of_mass():
    arms = {name: lwr_dyn.load("lwr4plus", name) for name in ("computed", "printed", "physical")}
    s = statics_of(arms, 200, 0, 50.0, 1.0)
    off = s["printed"].gravity_off(s["computed"])
    m, g, c5z = 1.8789, 9.81, 0.0238 - 0.004375432
    assert off[4] <= m * g * c5z * (1 + 1e-9)
    assert off[4] > 0.9 * m * g * c5z
    assert s["physical"].gravity_off(s["computed"]).max() < 1e-9


@pytest.mark.parametrize(("robot", "task"), [("lwr4plus", "ist-clear"), ("wam7", "lspb"), ("kr30ha", "two-points")])
def test_each_paper_sets_its_task(robot, task):
    arm = lwr_dyn.load(robot)
    study = simulated_task(arm)
    assert study.task.name == task
    q = study.reference.sample(np.linspace(0, study.reference.duration, 50)).q
    assert ((q >= arm.lower - 1e-9) & (q <= arm.upper + 1e-9)).all()


BAD = [
    (lambda a: {"one": a}, {}, OptionError, "arms: 1; allowed: 2 to 8 readings or files"),
    (lambda a: {"a": a, "b": lwr_dyn.load("kr30ha")}, {}, ShapeError, "7"),
    (lambda a: {"a": a, "b": a}, {"task": "dance"}, UnknownNameError, "'dance'"),
    (lambda a: {"a": a, "b": a}, {"poses": 0}, OptionError, "poses: 0; allowed: from 1 to 1000000"),
    (lambda a: {"a": a, "b": a}, {"poses": 1_000_001}, OptionError, "poses: 1000001; allowed"),
    (lambda a: {"a": a, "b": a}, {"task": "two-points"}, OptionError, "task: lwr4plus has no mastering position"),
    (lambda a: dict.fromkeys("abcdefgh", a), {"task": "dance", "poses": 1}, UnknownNameError, "'dance'"),
    (lambda a: dict.fromkeys("abcdefghi", a), {}, OptionError, "arms: 9; allowed: 2 to 8 readings or files"),
    (lambda a: {"a": a, "b": a}, {"task": "dance", "poses": 1_000_000}, UnknownNameError, "'dance'"),
    (lambda a: {"a": a, "b": a}, {"rate": 0.0}, OptionError, "rate: 0"),
    (lambda a: {"a": a, "b": lwr_dyn.load("lwr4")}, {"task": "dance"}, MissingDataError, "masses"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "options", "error", "says"), BAD)
def test_bad_input(arm, make, options, error, says):
    with pytest.raises(error, match=says):
        sensitivity(make(arm), **options)


TIPS = np.array([[1.0, 2.0], [4.0, np.nan]])


def result_of(rates=None, stops=None, faults=None, models="ab"):
    """A run of each model on both plants, each with its rate, stop or fault by names such as "ab"."""

    def run(key):
        met = (stops or {}).get(key, "")
        figures = SimpleNamespace(stops=SimpleNamespace(met=bool(met), sentence=lambda: met))
        values = {"rate": (rates or {"ab": 2000.0}).get(key, 1000.0), "fault": (faults or {}).get(key, "")}
        return SimpleNamespace(model=key[0], plant=key[1], controller="pd", metrics=figures, **values)

    return SimpleNamespace(
        names=("a", "b"), rate=1000.0, runs=tuple(run(m + p) for m in models for p in "ab"),
        tip_rms_mm=lambda name: TIPS, worst_mrad=lambda name: 10 * TIPS,
    )  # fmt: skip


def test_errors_are_written_with_their_marks_and_shaded_by_their_share():
    table = error_table(result_of(), "pd")
    assert table.cells == (("a", "1 (10)", "2 (20)*"), ("b", "4 (40)", "no run"))
    assert table.shades == ((None, 0.0, pytest.approx(0.25)), (None, pytest.approx(0.75), 0.0))
    stopped = result_of(stops={"ab": "joint_6 on its stop for 1.6 s"})
    assert error_table(stopped, "pd").cells[0] == ("a", "1 (10)", "2 (20)*!")
    chatters = (
        "* at 1000 samples a second this loop chatters: the damping is too strong for the lighter plant, and needs {};"
        " simulated with the controller at every moment, or where joints stick or meet a stop at that rate"
    )
    assert notes(stopped) == [chatters.format(2000), "! pd, a on b: joint_6 on its stop for 1.6 s"]
    assert notes(result_of(rates={"ab": 3000.0, "bb": 2000.0})) == [chatters.format("2000 to 3000")]


@pytest.mark.parametrize(
    ("faults", "lines"),
    [
        ({"ab": "x", "bb": "x"}, ["no run of any law and model on b: x"]),
        ({"ab": "x", "bb": "y"}, ["no run of pd, a on b: x", "no run of pd, b on b: y"]),
        ({"ab": "x", "bb": "x", "cb": ""}, ["no run of pd, a; pd, b on b: x"]),
        ({"ab": "x"}, ["no run of pd, a on b: x"]),
    ],
)
def test_runs_that_failed_for_one_reason_are_one_line(faults, lines):
    models = "".join(dict.fromkeys(key[0] for key in faults))
    assert notes(result_of({"": 0.0}, faults=faults, models=models)) == lines
