"""`lwr_dyn.margins`: shares of the joint box, poles of the simulated step, the worst pose and its joint."""

import json

import numpy as np
import pytest

from lwr_dyn.design.loop_judgement import LoopCase
from lwr_dyn.design.loop_margins import largest_sensitivity
from lwr_dyn.design.margins import margins, percent
from lwr_dyn.design.sampled_stability import rate_text, wilson_interval
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.chain import JointKind
from lwr_dyn.simulation.integrators import held_rk4
from lwr_dyn.simulation.simulate import simulate
from tests.design.margin_cases import BENT, arm, dynamics, law
from tests.simulation.sample_runs import Still, one_joint

KNOWN = {"computed": 0.230, "printed": 0.172, "physical": 0.0}
"""Unstable share of the joint box at 1 kHz: PD with gravity, default gains, 2000 poses, by another program."""


def in_box(reading="physical", controller=None, poses=200, **options):
    return margins(
        arm(reading), controller or law("pd-gravity", reading), engine=dynamics(reading), poses=poses, **options
    )


@pytest.mark.slow
@pytest.mark.parametrize("reading", KNOWN)
def test_the_unstable_share_of_the_box_is_the_known_one(reading):
    found = in_box(reading, poses=2000).stability
    assert abs(found.share - KNOWN[reading]) <= 0.03
    assert found.interval == wilson_interval(found.unstable, 2000)
    assert found.interval[0] <= KNOWN[reading] <= found.interval[1]


def simulated_step(control, q, T=1e-3):
    """z -> the deviation from rest at q after one sample of the simulated loop."""
    advance, _ = held_rk4(ungated(dynamics()).forward_dynamics, 7, T, substeps=2)

    def after(z):
        start, end = np.array([q + z[:7], z[7:]]), np.empty((2, 7))
        advance(0.0, start, control(0.0, *start, q, *np.zeros((2, 7))), end)
        return (end - [q, np.zeros(7)]).ravel()

    return after


def test_poles_are_those_of_the_simulated_step_at_forty_poses():
    """By central differences of 1e-4 rad and rad/s. Inverse dynamics has double poles, which 1e-8 splits by 1e-4: of it
    the matrices are compared."""
    h = 1e-4
    for q in np.random.default_rng(4).uniform(arm().lower, arm().upper, (40, 7)):
        for name in ("pd-gravity", "inverse-dynamics"):
            after = simulated_step(law(name), q)
            step = np.array([after(e) - after(-e) for e in h * np.eye(14)]).T / (2 * h)
            loop = LoopCase().loop(arm(), dynamics(), law(name), q[None])
            exact = loop.step_matrices(LoopCase().sampling)[0]
            assert np.abs(step - exact).max() <= 1e-6 * np.abs(exact).max()
            if name == "pd-gravity":
                apart = np.abs(np.linalg.eigvals(step)[:, None] - np.linalg.eigvals(exact))
                assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) <= 1e-7


def test_that_step_is_the_one_of_simulate():
    z = 1e-4 * np.linspace(-1, 1, 14)
    run = simulate(
        arm(), law("pd-gravity"), Still(BENT, 1e-3), q0=BENT + z[:7], dq0=z[7:], substeps=2, saturate=False,
        position_limits=False, friction="none",
    )  # fmt: skip
    after = simulated_step(law("pd-gravity"), BENT)(z)
    np.testing.assert_allclose(np.concatenate([run.q[-1] - BENT, run.dq[-1]]), after, rtol=1e-9, atol=1e-15)


@pytest.mark.slow
def test_the_worst_pose_is_as_bad_as_the_report_says():
    found = in_box()
    peaks = largest_sensitivity(found.loops(found.worst.q[None]), found.case.sampling)[0]
    assert found.worst.is_stable
    assert found.worst.peak.max() == pytest.approx(peaks.max(), rel=1e-3)
    rows = np.random.default_rng(1).uniform(arm().lower, arm().upper, (200, 7))
    assert peaks.max() >= largest_sensitivity(found.loops(rows), found.case.sampling).max()
    unstable = in_box("computed")
    assert (unstable.worst.is_stable, unstable.worst.radius) == (False, pytest.approx(unstable.stability.radius))
    assert found.worst_joint == unstable.worst_joint == "joint_1"
    # the joint that moves most is the one that simulate shows
    run = simulate(
        arm("computed"), law("pd-gravity", "computed"), Still(unstable.worst.q, 0.01), q0=unstable.worst.q + 1e-9,
        saturate=False, position_limits=False, friction="none",
    )  # fmt: skip
    energy = run.dq[6] ** 2 * np.diag(dynamics("computed").mass_matrix(unstable.worst.q))
    assert unstable.joint == int(np.argmax(energy))


def test_a_plain_function_is_judged_as_the_law_that_it_is_and_this_is_said():
    own, plain = in_box(q=[BENT]), in_box(controller=lambda *state: law("pd-gravity")(*state), q=[BENT])
    assert own.notes == ()
    assert "linearised by central differences" in plain.notes[0]
    assert plain.worst.radius == pytest.approx(own.worst.radius, abs=1e-7)
    np.testing.assert_allclose(plain.worst.gain_up, own.worst.gain_up, rtol=1e-3)
    assert "central differences" in str(plain)


@pytest.mark.slow
def test_payload_delay_and_elastic_joints_are_judged_as_they_are():
    free, loaded = (in_box(q=[BENT], plant=x) for x in (None, arm_with_payload(arm(), 7.0)))
    late = in_box(q=[BENT], delay=3)
    assert late.worst.delay_margin < free.worst.delay_margin
    assert late.worst.peak.max() > free.worst.peak.max()
    assert abs(loaded.worst.radius - free.worst.radius) > 1e-5
    link, motor = (in_box(q=[BENT], elasticity=1e4, encoders=side) for side in ("link", "motor"))
    assert (link.worst.is_stable, motor.worst.is_stable) == (False, True)
    assert (link.loop.plant.size, free.loop.plant.size) == (28, 14)
    stiff = in_box(q=[BENT], elasticity=1e8)
    np.testing.assert_allclose(stiff.worst.peak, free.worst.peak, rtol=2e-3)


def test_the_record_has_what_programs_ask_for():
    record = json.loads(json_text(in_box("computed", poses=50).record()))
    assert {"unstable_share", "least_rate_hz", "worst_q", "worst_joint"} <= set(record)
    assert record["unstable_share"] == record["unstable"] / 50
    assert (record["worst"]["gain_up"], record["holds"]) == ([None] * 7, False)


def test_the_text_says_all_of_the_worst_pose():
    found = in_box(q=[BENT], delay=1)
    worst, lines = found.worst, [" ".join(line.split()) for line in str(found).splitlines()]
    downs = ["under 0.001" if x == 0.0 else f"{x:.3g}" for x in worst.gain_down]
    rows = zip(arm().joint_names, worst.peak, worst.peak_hz, worst.gain_up, downs, strict=True)
    assert (downs.count("under 0.001"), lines) == (6, [
        "lwr4plus, reading physical: PD + gravity, damping on dq; rigid, 1000 Hz, delay of 1 sample",
        "linear and at rest: without speeds, friction, torque limits and stops",
        "unstable: 0 of 1 given poses",
        f"stable from: {rate_text(found.stability.least_rate)}",
        "|S_ii| above 1.7: 0 of 1 of them",
        "worst pose: (17 57 -29 -80 46 52 0) deg",
        f"worst joint: joint_{worst.peak.argmax() + 1}",
        "",
        f"largest factor of a deviation from sample to sample: {worst.radius:.4g}",
        "joint max |S_ii| at [Hz] gain up to gain down to",
        "------- ---------- ------- ---------- ------------",
        *(f"{name} {peak:.3f} {hz:.3g} {up:.3g} {down}" for name, peak, hz, up, down in rows),
        f"gain of all torques together, up to: {worst.all_up:.3g}",
        f"gain of all torques together, down to: {worst.all_down:.3g}",
        f"delay of all torques together, up to: {1e3 * worst.delay_margin:.3g} ms",
    ])  # fmt: skip
    stable, record = found.stability, json.loads(json_text(found.record()))
    poles = np.column_stack([worst.poles.real, worst.poles.imag]).tolist()
    assert record == {
        "robot": "lwr4plus", "reading": "physical", "controller": found.controller, "label": found.label,
        "case": found.case.words, "rate": 1000.0, "delay": 1, "where": "given poses", "poses": 1, "unstable": 0,
        "unstable_share": 0.0, "unstable_share_interval": [*stable.interval], "least_rate_hz": stable.least_rate,
        "limit": 1.7, "above_limit_poses": 1, "above_limit_share": 0.0,
        "above_limit_interval": [*wilson_interval(0, 1)], "holds": True, "worst_q": BENT.tolist(),
        "worst_joint": found.worst_joint, "unknown_limits": [], "notes": [], "caveats": record["caveats"],
        "worst": {
            "q": BENT.tolist(), "radius": worst.radius, "stable": True, "poles": poles, "all_up": worst.all_up,
            "all_down": worst.all_down, "delay_margin": worst.delay_margin,
            **{key: getattr(worst, key).tolist() for key in ("peak", "peak_hz", "gain_up", "gain_down")},
        },
    }  # fmt: skip
    lines = str(in_box("computed", q=np.radians([[-65, 0, 170, 1, -55, 17, -61]]))).splitlines()
    assert lines[3:5] == ["unstable: 1 of 1 given poses", "stable from: 6920 Hz"]
    assert lines[-1] == "unstable, no margins there; the fastest deviation swings at: 500 Hz"


def test_over_the_box_poses_are_drawn_and_the_worst_is_searched():
    """A pendulum: gravity makes it stiffer below and less stiff above."""
    pendulum = one_joint(JointKind.REVOLUTE, 2.0, 0.5, (0.0, -9.81, 0.0), lower=-1.0, upper=2.0)
    options = {"inertia": [0.52], "omega_n": 4.0, "delay": 2, "limit": 1.1, "poses": 30}
    rows, grid = np.random.default_rng(3).uniform(-1.0, 2.0, (30, 1)), np.linspace(-1.0, 2.0, 301)[:, None]
    box, given = (margins(pendulum, "pd-gravity", q=q, seed=3, **options) for q in (None, rows))
    peaks = [largest_sensitivity(box.loops(q), box.case.sampling)[:, 0] for q in (rows, grid)]
    assert (box.where, given.where) == ("joint box", "given poses")
    assert box.above == given.above == np.count_nonzero(peaks[0] > 1.1)
    assert 0 < box.above < box.peak_poses == given.peak_poses == 30
    assert given.worst.q[0] == rows[peaks[0].argmax()]
    assert box.worst.q[0] == pytest.approx(grid[peaks[1].argmax(), 0], abs=0.011)
    assert f"|S_ii| above 1.1: {percent(box.above / 30, box.above_interval)} of 30 of them" in str(box)
    assert not box.holds


@pytest.mark.parametrize(
    ("changed", "error", "fault"),
    [
        ({"limit": 1.0}, OptionError, "a number above 1"),
        ({"poses": 0}, OptionError, "a whole number above 0"),
        ({"q": [0.0]}, ShapeError, "7 numbers"),
        ({"controller": "pd-gravty"}, UnknownNameError, "did you mean pd-gravity"),
        ({"rate": -1.0}, OptionError, "a number above 0"),
        ({"delay": 101}, OptionError, "from 0 to 100"),
        ({"elasticity": "file", "arm": one_joint()}, MissingDataError, "stiffness"),
        ({"elasticity": -1.0}, OptionError, "above 0"),
        ({"cutoff_hz": 500.0}, OptionError, "below 500 Hz"),
        ({"arm": "lwr4plus"}, OptionError, "an arm"),
    ],
)
def test_bad_input_is_named(changed, error, fault):
    given = {"arm": arm(), "controller": "inverse-dynamics", "poses": 3} | changed
    with pytest.raises(error, match=fault):
        margins(given.pop("arm"), given.pop("controller"), **given)
