"""Joints on their stops: counted from the run, and said wherever a figure of that run is shown."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.simulate import run_document
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.run import Event
from lwr_dyn.pages.replay.replay_page import page_data
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.simulation.metrics import RIGID, metrics, stop_contacts
from lwr_dyn.trajectory.references.joint_moves import lspb_move
from tests.simulation.sample_runs import lwr


@pytest.fixture(scope="module")
def leaning():
    """The first half second of IST with 3 kg that the controller does not know: joint 6 falls on its stop."""
    arm = lwr()
    reference, controller = lwr_dyn.reference("ist", arm), lwr_dyn.controller("inverse-dynamics", arm)

    def run(**options):
        return lwr_dyn.simulate(arm, controller, reference, plant=arm_with_payload(arm, 3.0), duration=0.5, **options)

    return run


def test_time_at_the_stop_is_that_between_impact_and_release(leaning):
    run = leaning()
    (impact,) = (event.t for event in run.events)
    contacts = stop_contacts(run, lwr())
    np.testing.assert_allclose(contacts.seconds, [0, 0, 0, 0, 0, 0.5 - impact, 0], atol=1e-3)
    assert contacts.impacts == (0, 0, 0, 0, 0, 1, 0)
    assert contacts.sentence() == "joint_6 on its stop for 0.48 s"


def test_limits_kept_by_a_stop_are_not_kept_by_the_controller(leaning):
    figures = metrics(leaning(), lwr())
    assert not figures.within_limits
    assert figures.limits == f"kept, but {figures.stops.contacts()}"
    assert figures.stops.contacts() == "joint_6 ran into its stop once (at 0.0234 s) and was on it for 0.48 s"
    record = json.loads(json.dumps(figures.to_json()))
    assert record["within_limits"] is False
    assert record["at_stop_s"][5] == pytest.approx(0.476, abs=1e-3)
    assert record["stop_impacts"] == [0, 0, 0, 0, 0, 1, 0]


def test_a_run_without_stops_passes_the_limit(leaning):
    figures = metrics(leaning(position_limits=False), lwr())
    assert (figures.stops.met, figures.caveat) == (False, RIGID)
    assert figures.limits == "NOT kept (position of joint_6)"


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


def test_an_impact_without_rest_is_said_too(leaning):
    run = leaning(position_limits=False)
    touched = replace(run, events=(Event(0.1, "stop", 2, 0.0), Event(0.1, "stop", 2, 0.0)))
    contacts = stop_contacts(touched, lwr())
    assert (contacts.met, contacts.impacts[2], contacts.sentence()) == (True, 2, "joint_3 met its stop")
    assert contacts.contacts() == "joint_3 ran into its stop twice (first at 0.1 s)"


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
