"""Figures of merit of runs written by hand."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.simulate import run_document
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Event, Run
from lwr_dyn.pages.replay.replay_page import page_data
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.simulation.metrics import RIGID, metrics, stop_contacts
from lwr_dyn.trajectory.references.joint_moves import lspb_move
from tests.random_arms import random_arm
from tests.simulation.sample_runs import lwr, one_joint, with_limits


def run_of(q, q_ref, dq=0.0, command=0.0, applied=None):
    t = np.arange(len(q)) * 0.1
    q = np.asarray(q, dtype=float).reshape(len(t), -1)

    def column(value):
        return np.broadcast_to(np.reshape(value, (-1, 1)) if np.ndim(value) == 1 else value, q.shape)

    applied = command if applied is None else applied
    return Run(
        t, q, column(dq), column(q_ref), 0 * q, column(command), column(applied), 0 * q, energy=0 * t,
        work={"actuator": 0 * t},
    )  # fmt: skip


ARM = one_joint(JointKind.REVOLUTE, lever=0.5, lower=-1.0, upper=2.0, velocity=4.0, effort=10.0)


def test_errors_in_mrad():
    figures = metrics(run_of([0.0, 0.0, 0.0, 0.0], [0.001, -0.003, 0.0, 0.004], dq=[0.0, 0.5, 0.0, 0.0]), ARM)
    found = [
        [getattr(error, name)[0] for name in ("mean", "mean_abs", "max", "min", "rms")]
        for error in (figures.position_mrad, figures.velocity_mrad_s)  # ref - actual
    ]
    wanted = [[0.5, 2.0, 4.0, -3.0, np.sqrt(26 / 4)], [-125.0, 125.0, 0.0, -500.0, 250.0]]
    np.testing.assert_allclose(found, wanted, atol=1e-12)
    (joint, unit, *errors, _, _, _, _), *rest = figures.table(full=True).rows
    assert (joint, unit, rest) == ("joint_1", "mrad", [])
    np.testing.assert_allclose(errors, [*wanted[0], *wanted[1][1:4]], atol=1e-12)
    assert figures.table(full=True).text().splitlines()[0].split("  ")[0] == "joint"


def test_torques_speeds_and_margins():
    run = run_of([0.0, 1.5, -0.9], 0.0, dq=[0.0, -2.0, 1.0], command=[5.0, -20.0, 30.0], applied=[5.0, -10.0, 10.0])
    names = ("peak_torque", "peak_command", "torque_use", "peak_speed", "speed_use", "limit_margin", "saturated_s")
    found = [getattr(metrics(run, ARM), name)[0] for name in names]
    assert found == pytest.approx([10.0, 30.0, 1.0, 2.0, 0.5, 0.1, 0.1])  # the last sample is held for no time
    runs = (run, run_of([0.0, 1.5], 0.0, command=[5.0, 5.0]), run_of([0.0, 2.1], 0.0),
            run_of([0.0, 0.0], 0.0, dq=[0.0, 4.1]))  # fmt: skip
    assert [metrics(each, ARM).within_limits for each in runs] == [False, True, False, False]
    free = replace(ARM, limits=(replace(ARM.limits[0], effort=None),))
    shown = [metrics(run, arm).table().text().splitlines()[-1].split()[-1] for arm in (ARM, free)]
    assert (shown, metrics(run, free).to_json()["saturated_s"]) == (["0.1", "?"], [None])


@pytest.mark.parametrize(("kinds", "unit"), [("RR", "N m"), ("PP", "N"), ("RP", "N m, N")])
def test_torques_have_the_units_of_the_joints(kinds, unit):
    headings = [
        heading.head for heading in metrics(run_of(np.zeros((2, 2)), 0.0), random_arm(1, kinds)).table().columns
    ]
    assert f"peak torque [{unit}]" in headings


def test_unknown_limits_are_nan_and_null():
    figures = metrics(run_of([0.0, 1.5], 0.0, dq=[1e6, 0.0], command=[1e6, 0.0]), one_joint())
    assert np.isnan(figures.torque_use[0])
    assert (figures.within_limits, figures.limits) == (None, "position, speed and torque unknown")
    record = json.loads(json.dumps(figures.to_json()))
    wanted = {"torque_use": [None], "limit_margin": [None], "within_limits": None}
    assert {name: record[name] for name in wanted} == wanted
    assert record["position_mrad"]["mean"] == [-750.0]


def test_tip_error():
    q_ref, zero = np.zeros((3, 7)), np.zeros((3, 7))
    q_ref[1, 1] = 0.01  # the straight arm leans: 0.868 m of lever
    run = Run(np.arange(3) * 0.1, zero, zero, q_ref, zero, zero, zero, zero, np.zeros(3), {})
    lever = 1e3 * lwr_dyn.forward_kinematics(lwr(), np.zeros(7))[2, 3]
    figures = metrics(run, lwr())
    assert figures.tip_max_mm == pytest.approx(2 * lever * np.sin(0.005), rel=1e-12)
    assert figures.tip_rms_mm == pytest.approx(figures.tip_max_mm / np.sqrt(3), rel=1e-12)
    with pytest.raises(ShapeError, match="joints"):
        metrics(run_of([0.0], 0.0), with_limits(lwr(), velocity=1.0))


@pytest.fixture(scope="module")
def leaning():
    """The first half second of IST with 3 kg that the controller does not know: joint 6 falls on its stop."""
    arm = lwr()
    reference, controller = lwr_dyn.reference("ist", arm), lwr_dyn.controller("inverse-dynamics", arm)

    @cache
    def run(**options):
        return lwr_dyn.simulate(arm, controller, reference, plant=arm_with_payload(arm, 3.0), duration=0.5, **options)

    return run


def test_time_at_the_stop_is_that_between_impact_and_release(leaning):
    run = leaning()
    (impact,) = (event.t for event in run.events)
    contacts = stop_contacts(run, lwr())
    np.testing.assert_allclose(contacts.seconds, [0, 0, 0, 0, 0, 0.5 - impact, 0], atol=1e-3)
    assert (contacts.impacts, contacts.sentence()) == ((0, 0, 0, 0, 0, 1, 0), "joint_6 on its stop for 0.48 s")
    touched = replace(leaning(position_limits=False), events=(Event(0.1, "stop", 2, 0.0),) * 2)
    contacts = stop_contacts(touched, lwr())  # an impact without rest
    assert (contacts.met, contacts.impacts[2], contacts.sentence()) == (True, 2, "joint_3 met its stop")
    assert contacts.contacts() == "joint_3 ran into its stop twice (first at 0.1 s)"


def test_limits_kept_by_a_stop_are_not_kept_by_the_controller(leaning):
    figures = metrics(leaning(), lwr())
    assert figures.limits == f"kept, but {figures.stops.contacts()}"
    assert figures.stops.contacts() == "joint_6 ran into its stop once (at 0.0234 s) and was on it for 0.48 s"
    record = json.loads(json.dumps(figures.to_json()))
    wanted = {"within_limits": False, "stop_impacts": [0, 0, 0, 0, 0, 1, 0]}
    assert {name: record[name] for name in wanted} == wanted
    assert record["at_stop_s"][5] == pytest.approx(0.476, abs=1e-3)
    figures = metrics(leaning(position_limits=False), lwr())
    assert (figures.stops.met, figures.caveat) == (False, RIGID)
    assert figures.limits == "position NOT kept (joint_6); speed and torque kept"


def test_the_stop_is_said_in_text_json_and_page(leaning):
    run, arm = leaning(), lwr()
    said = "joint_6 on its stop for 0.48 s"
    first, *lines = run_document(run, arm).text().splitlines()
    assert first.endswith("501 samples")
    assert any(line.endswith(f"kept, but {stop_contacts(run, arm).contacts()}") for line in lines)
    assert f"tip error ({RIGID}; {said}): largest" in "\n".join(lines)
    assert run_document(run, arm).record()["metrics"]["tip_caveat"] == f"{RIGID}; {said}"
    (card,) = page_data(replayed_runs([run], arm))["runs"]
    assert (card["stops"], card["tip_model"]) == (said, RIGID)


def test_a_joint_at_its_limit_that_nothing_presses_against_it_has_met_no_stop():
    """The WAM's task starts with joint 2 at its limit, held there by friction until the motion draws it away."""
    arm = lwr_dyn.load("wam7")
    start = np.array([0.0, -2.0, 0.0, 1.6, 0.0, 0.0, 0.0])
    assert start[1] == arm.lower[1]
    move = lspb_move(arm, start, start + 0.5, duration=7.0, blend=1.0)

    def contacts(payload):
        controller = lwr_dyn.controller("pd-gravity", arm, own_gains=True)
        run = lwr_dyn.simulate(arm, controller, move, substeps=2, duration=0.2, payload=payload)
        assert (run.q[:50, 1] == arm.lower[1]).all()
        return stop_contacts(run, arm)

    assert not contacts(0.0).met
    assert contacts(3.0).sentence() == "joint_2 on its stop for 0.2 s"


def test_a_run_file_without_the_count_is_judged_by_its_positions(leaning):
    run, arm = leaning(), lwr()
    counted = stop_contacts(run, arm)
    older = replace(run, meta={key: value for key, value in run.meta.items() if key != "at_stop_s"})
    np.testing.assert_allclose(stop_contacts(older, arm).seconds, counted.seconds, atol=1.001e-3)
    q = leaning(position_limits=False).q.copy()
    q[0, 0] = arm.upper[0]  # it starts at a limit and leaves
    assert stop_contacts(replace(older, q=q, events=()), arm).sentence() == ""
    with pytest.raises(ShapeError, match="at_stop_s"):
        stop_contacts(replace(run, meta={"at_stop_s": [1.0]}), arm)


def test_an_unknown_limit_is_not_kept():
    """The KR 30 HA has no torque limits; an arm may know some of its speeds."""
    arm = lwr_dyn.load("kr30ha")
    hold = lwr_dyn.reference("hold", arm, q=np.radians([0, -60, 60, 0, 30, 0]), duration=0.02)
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), hold)
    figures = metrics(run, arm)
    assert figures.within_limits is None
    assert figures.limits == "position and speed kept; torque unknown"
    assert "limits of position, speed and torque: position and speed kept; torque unknown" in figures.document.text()
    assert figures.to_json()["within_limits"] is None
    some = replace(
        arm, limits=tuple(replace(x, effort=None if k else 1e6, velocity=1e-9) for k, x in enumerate(arm.limits))
    )
    moved = replace(run, dq=run.dq + 1.0)
    assert metrics(moved, some).limits == (
        f"speed NOT kept ({', '.join(arm.joint_names)}); position kept; "
        f"torque kept where known, unknown of {', '.join(arm.joint_names[1:])}"
    )
    assert metrics(moved, some).within_limits is False
    compared = lwr_dyn.compare(run, run)
    assert "unknown" in compared.table.text()
