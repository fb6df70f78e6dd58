"""`krl write` of tables of axes, which move in proportion between rows, and of a run that ends with a pause."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError, OptionError
from lwr_dyn.krl.writing.path_fit import fitted_motions
from lwr_dyn.krl.writing.path_program import WritingOptions, write_path
from lwr_dyn.krl.writing.sampled_path import _along, path_of_motion, read_sampled_path
from tests.krl.short_programs import HOME, run_of
from tests.krl.writing.test_path_program import dense, hausdorff, tool_places


def test_the_last_pause_belongs_to_the_path(arm):
    run = run_of(arm, HOME, "LIN_REL {Z -100}", "WAIT SEC 2")
    assert path_of_motion(run.to_run(), arm).duration == pytest.approx(run.cycle_time, abs=1e-3)


def test_between_rows_of_axes_the_axes_move_in_proportion(arm, tmp_path):
    """A line in their place would be 4.9 mm off."""
    (tmp_path / "a.csv").write_text("A1,A2,A3,A4,A5,A6\n0,-90,90,0,30,0\n10,-90,90,0,30,0\n40,-60,90,60,30,0\n")
    path = read_sampled_path(tmp_path / "a.csv", arm)
    written = write_path(path, WritingOptions(kinds=("PTP",), approximate=False))
    assert written.holds
    assert written.deviation.position < 5e-5
    fitted = write_path(path, WritingOptions())
    assert fitted.holds
    t = np.linspace(0.0, fitted.run.cycle_time, 4000)
    truth = np.interp(np.linspace(0, 2, 4000), [0, 1, 2], [0, 1, 2])
    rows = np.radians([[0, -90, 90, 0, 30, 0], [10, -90, 90, 0, 30, 0], [40, -60, 90, 60, 30, 0]])
    q = np.stack([np.interp(truth, [0, 1, 2], x) for x in rows.T], axis=1)
    places = [dense(tool_places(arm, x, np.eye(4)), 2000) for x in (q, fitted.run.timeline.sample(t).q)]
    assert hausdorff(*places) < 1.5e-3


@pytest.mark.parametrize("kind", ["PTP", "CIRC"])
def test_a_way_that_turns_round_is_as_many_motions_and_a_wide_angle_does_not_forbid_paths_in_space(arm, tmp_path, kind):
    """About A1 the tool's way is an arc, there and back on the same places."""
    rows = "".join(f"{a1},-90,90,0,30,0\n" for a1 in (0, 20, 18, 30))
    (tmp_path / "a.csv").write_text(f"A1,A2,A3,A4,A5,A6\n{rows}")
    path = read_sampled_path(tmp_path / "a.csv", arm)
    motions = fitted_motions(path, (1e-4, 0.9), (kind,))
    assert [one.kind for one in motions] == [kind] * 3
    np.testing.assert_allclose(np.degrees([path.q[one.last, 0] for one in motions]), [20, 18, 30], atol=1e-9)


WRONG = {
    "X,Y,Z\n1,2,3\n4,5,6\n": "no column A, B, C",
    "X,Y,Z,A,B,C\n1,2,3,0,0,0\n": "1 rows of numbers",
    "X,Y,Z,A,B,C\n1,2,3,0,0,0\n1,2,x,0,0,0\n": "row 3 is '1,2,x,0,0,0'; allowed: 6 finite numbers",
    "X,Y,Z,A,B,X\n1,2,3,0,0,0\n1,2,3,0,0,1\n": "a column that is there twice",
    "t,A1,A2,A3,A4,A5,A6\n1,0,-90,90,0,0,0\n0,0,-90,80,0,0,0\n": "times that do not grow",
    "A1,A2,A3,A4,A5,A6\n0,-90,90,0,0,0\n0,-90,90,0,0,0\n": "nothing moves",
    "A1,A2,A3,A4,A5,A6\n0,-90,90,0,0,0\n0,-90,90,0,0,9999\n": "A6 outside its range by",
    "X,Y,Z,A,B,C\n9000,0,0,0,0,0\n9001,0,0,0,0,0\n": "no branch follows it: out of reach by",
    "X,Y,Z,A,B,C\n900,0,900,0,0,0\n900,0,900,0,0,0\n": "nothing moves",
    "X,Y,Z,A,B,C\n900,0,900,0,0,0\n900,0,9E8,0,0,0\n": "too long; allowed: at most 200000 samples, 2 mm apart",
    "A1,A2,A3,A4,A5,A6\n0,-90,90,0,0,0\n0,-90,90,0,0,1E6\n": "too long; allowed: at most 200000 samples, 0.5 deg apart",
    "X,Y,Z,A,B,C,S,T\n1000,0,1400,0,90,0,5,0\n1000,9,1400,0,90,0,5,0\n": "no branch follows it: it begins with S ",
    "X,Y,Z,A,B,C\n900,0,900,0,0,0\n900,0,900,180,0,0\n": "half a turn between rows 2 and 3",
}


@pytest.mark.parametrize(("text", "message"), WRONG.items())
def test_a_wrong_table_is_one_line(arm, tmp_path, text, message):
    (tmp_path / "wrong.csv").write_text(text)
    with pytest.raises(LwrDynError) as fault:
        read_sampled_path(tmp_path / "wrong.csv", arm)
    assert message in str(fault.value)


def test_rows_of_poses_that_repeat_count_once_and_those_between_take_their_share_of_the_time(arm, tmp_path):
    rows = "0,1000,0,1400,0,90,0\n1,1000,0,1400,0,90,0\n3,1000,6,1400,0,90,0\n4,1000,6,1400,0,90,1.4\n"
    (tmp_path / "a.csv").write_text(f"t,X,Y,Z,A,B,C\n{rows}")
    path = read_sampled_path(tmp_path / "a.csv", arm)
    np.testing.assert_allclose(path.t, [0.0, 1 + 2 / 3, 1 + 4 / 3, 3.0, 3 + 1 / 3, 3 + 2 / 3, 4.0], atol=1e-12)
    np.testing.assert_allclose(1e3 * path.T[:, 1, 3], [0, 2, 4, 6, 6, 6, 6], atol=1e-9)
    np.testing.assert_allclose(lwr_dyn.forward_kinematics(arm, path.q), path.T, atol=1e-9)


def test_a_program_is_no_table_and_six_axes_are_no_way_of_an_arm_with_seven(arm, tmp_path):
    (tmp_path / "a.src").write_text("DEF a( )\nWAIT SEC 1\nEND\n")
    with pytest.raises(FileAccessError, match=r"a program, no path; allowed: a \.csv"):
        read_sampled_path(tmp_path / "a.src", arm)
    (tmp_path / "a.csv").write_text("A1,A2,A3,A4,A5,A6\n0,-90,90,0,30,0\n10,-90,90,0,30,0\n")
    with pytest.raises(OptionError, match="6 joints"):
        read_sampled_path(tmp_path / "a.csv", lwr_dyn.load("lwr4plus"))


def way(*degrees):
    """A1 at each sample; the others stand."""
    q = np.tile(np.radians([0.0, -90.0, 90.0, 0.0, 30.0, 0.0]), (len(degrees), 1))
    q[:, 0] = np.radians(degrees)
    return q


@pytest.mark.parametrize(
    ("degrees", "excess", "first", "fault"),
    [
        ((0, 10), 0.25, None, (0.0, "out of reach by 250 mm")),
        ((0, 30, 130, 140), 0.0, None, (0.25, "an axis turns by 100 deg at sample 3")),
        ((170, -175, -160), 0.0, None, (0.5, "A1 leaves its range by 15 deg")),
        ((170, -177), 0.0, 170, (1.0, "")),
        ((340, 350), 0.0, -20, (1.0, "")),
        ((-340, -350), 0.0, 20, (1.0, "")),
    ],
)
def test_a_branch_is_followed_in_the_range_of_its_axes_or_it_is_said_how_far_and_why_not(
    arm, degrees, excess, first, fault
):
    found, why = _along(arm, way(*degrees), excess, way(0)[0])
    assert why == fault
    assert (found is None) == (first is None)
    if found is not None:
        np.testing.assert_allclose(
            found, way(first, first + np.rad2deg(np.unwrap(np.radians(degrees)))[1] - degrees[0])
        )
