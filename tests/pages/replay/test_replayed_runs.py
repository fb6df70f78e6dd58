"""A run with its arm, label and colour: poses are forward kinematics, labels are numbered, misfits are refused."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import facts, replayed_runs, run_name, run_places


def test_poses_and_tip_error_are_those_of_forward_kinematics(arm, two_runs):
    (run,) = replayed_runs(two_runs[:1], arm)
    poses = [flange_pose(arm.chain, q) for q in (two_runs[0].q, two_runs[0].q_ref)]
    np.testing.assert_array_equal(run.pose, poses[0])
    np.testing.assert_array_equal(run.reference_path, poses[1][:, :3, 3])
    np.testing.assert_allclose(run.tip_error, np.linalg.norm((poses[1] - poses[0])[:, :3, 3], axis=1))
    assert run.tip_error.max() > 1e-3


def test_labels_are_given_or_are_the_controllers_numbered_where_they_repeat(arm, two_runs):
    one, other = two_runs
    assert [run.label for run in replayed_runs([one, other, one], arm)] == [
        "pd-gravity 1", "inverse-dynamics", "pd-gravity 2",
    ]  # fmt: skip
    loaded = replace(one, meta={**one.meta, "payload": {"mass": 3.0}})
    assert [run.label for run in replayed_runs([loaded, one], arm)] == [
        "pd-gravity, 3 kg at the flange", "pd-gravity",
    ]  # fmt: skip
    renamed = replace(other, meta={**other.meta, "robot": "wam7"})
    assert [run.label for run in replayed_runs([one, renamed], arm)] == [
        "lwr4plus: pd-gravity",
        "wam7: inverse-dynamics",
    ]
    many = replayed_runs([one] * 7, [arm] * 7, labels=list("abcdefg"))
    assert [run.label for run in many] == list("abcdefg")
    assert sorted(run.place for run in many) == [0, 1, 2, 3, 4, 4, 4]


def test_a_lambda_is_an_own_controller_also_in_a_run_of_an_older_version(arm, two_runs):
    words = "<lambda>, with a momentum observer"
    old = [replace(two_runs[0], meta={**two_runs[0].meta, "controller": c}) for c in ("<lambda>", {"label": words})]
    assert [run.label for run in replayed_runs(old, arm)] == [
        "own controller", "own controller, with a momentum observer",
    ]  # fmt: skip


NAMES = [
    ("inverse-dynamics", "", "a"), ("pd-gravity", "", "b"), ("pid", "", "c"), ("mine.py", "", "d"),
    ("pd-gravity", "masses times 1.2", "b"),
]  # fmt: skip


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_a_run_has_one_colour_alone_and_in_every_company_of_other_controllers(size):
    for chosen in itertools.permutations(NAMES[:4], size):
        assert (
            dict(zip(chosen, run_places(chosen), strict=True)).items()
            <= dict(zip(NAMES[:4], range(4), strict=True)).items()
        )


def test_runs_of_one_picture_have_their_own_places_in_any_order_and_the_fifth_is_grey():
    for chosen in itertools.permutations(NAMES[1:]):
        assert dict(zip(chosen, run_places(chosen), strict=True))[NAMES[4]] == 0
    assert dict(zip(NAMES, run_places(NAMES), strict=True))[NAMES[4]] == 4
    assert run_places([("a", "", "")] * 6) == (3, 0, 1, 2, 4, 4)
    assert run_places([("pid", "", "PID without gravity"), ("pid", "masses times 1.2", "PID")]) == (0, 2)


def test_the_name_is_what_the_run_file_has(arm, two_runs, tmp_path):
    meta = {"controller": {"name": "pid", "label": "PID + gravity"}, "note": {"plant": "masses times 1.2"}}
    run = replace(two_runs[0], meta=meta)
    assert run_name(run) == ("pid", "masses times 1.2", "PID + gravity")
    assert run_name(replace(run, meta=meta | {"note": {"plant": "as modelled"}})) == ("pid", "", "PID + gravity")
    run.save(tmp_path / "run.npz")
    (shown,) = replayed_runs([type(run).load(tmp_path / "run.npz")], arm)
    assert (shown.place, shown.colour) == (2, tokens()["run3"])


def test_facts_come_from_the_note_before_the_meta_and_only_as_text(two_runs):
    meta = {"robot": "r", "reading": 3, "controller": {"name": "pid"}, "task": "wave", "note": {"task": "ist"}}
    assert facts(replace(two_runs[0], meta=meta)) == {"robot": "r", "controller": "pid", "task": "ist"}


def test_a_load_is_named_with_its_place_and_whether_it_is_known(two_runs):
    load = {"mass": 3.0, "com": [0.0, 0.0, 0.0], "inertia": None}
    known = {"payload": load, "controller": {"name": "pid", "label": "PID"}, "note": {"payload_known": True}}
    assert facts(replace(two_runs[0], meta={"payload": load})) == {"payload": "3 kg at the flange"}
    assert facts(replace(two_runs[0], meta=known)) == {
        "controller": "PID", "payload": "3 kg at the flange, known to the controller",
    }  # fmt: skip
    off = {"payload": load | {"com": [0, 0, 0.05]}}
    assert facts(replace(two_runs[0], meta=off)) == {"payload": "3 kg at (0, 0, 0.05) m from the flange"}


def test_mount_and_tool_have_units(two_runs):
    given = {
        "mount": {"on": "ceiling", "xyz": [0, 0, 2.5]},
        "tool": {"xyz": [0, 0, 0.1], "rpy_deg": [0, 90, 0], "mass": 0.5},
    }
    assert facts(replace(two_runs[0], meta={"loaded_with": given})) == {
        "mount": "ceiling, at (0, 0, 2.5) m", "tool": "at (0, 0, 0.1) m, rpy (0, 90, 0) deg, 0.5 kg",
    }  # fmt: skip


def test_misfits_are_refused(arm, two_runs):
    run = two_runs[0]
    with pytest.raises(OptionError, match="runs: none; allowed: one or more"):
        replayed_runs([], arm)
    with pytest.raises(OptionError, match="arms: 1 for 2 runs; allowed: one per run"):
        replayed_runs(two_runs, [arm])
    with pytest.raises(OptionError, match="labels: 1 for 2 runs; allowed: one per run"):
        replayed_runs(two_runs, arm, ["a"])
    with pytest.raises(OptionError, match="labels: 'ab'; allowed: a list of names, one per run"):
        replayed_runs(two_runs, arm, "ab")
    for name in ("tau_applied", "q"):
        with pytest.raises(ShapeError, match=rf"{name} of pd-gravity: shape \(3001, 6\); allowed: \(3001, 7\)"):
            replayed_runs([replace(run, **{name: getattr(run, name)[:, :6]})], arm)
    with pytest.raises(ShapeError, match="nan"):
        replayed_runs([replace(run, q=np.full_like(run.q, np.nan))], arm)
    for t in (np.zeros_like(run.t), run.t[::-1]):
        with pytest.raises(ShapeError, match="strictly growing"):
            replayed_runs([replace(run, t=t)], arm)
    trace = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    (drawn,) = replayed_runs([replace(run, meta={"reference_trace": trace})], arm)
    assert drawn.reference_path.tolist() == trace
    (bent,) = replayed_runs([replace(run, meta={"reference_trace": [[1, 2]]})], arm)
    with pytest.raises(ShapeError, match=r"reference_trace: shape \(1, 2\)"):
        _ = bent.reference_path
