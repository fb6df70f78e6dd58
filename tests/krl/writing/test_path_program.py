"""`krl write` of a run or a table: PTP, LIN and CIRC within the tolerance, Status and Turn solved, run and compared."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.spherical_wrist import wrist_arm_geometry
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.robot.kuka_pose import frame_matrix
from lwr_dyn.krl.running.program_run import ProgramError, run_program
from lwr_dyn.krl.writing.motion_program import Approximation, PathProgram, ProgramSpeeds, _root, speeds_of
from lwr_dyn.krl.writing.path_fit import FittedMotion, Tolerance, _reach, fitted_motions, path_deviation
from lwr_dyn.krl.writing.path_program import WritingOptions, _possible, _slow_enough, write_path
from lwr_dyn.krl.writing.sampled_path import path_of_motion, read_sampled_path
from lwr_dyn.model.run import Motion
from tests.krl.short_programs import HOME, run_of

TURN = 2.0 * np.pi


def fourier(arm, seed, duration=3.0):
    """A motion of all axes, as an exciting motion has them."""
    rng, t = np.random.default_rng(seed), np.linspace(0.0, duration, 1501)
    parts = [(k * TURN / duration, 0.2 / k * rng.normal(size=6)) for k in (1, 2)]
    q = np.radians([0, -90, 90, 20, 50, 0]) + sum(np.sin(w * t)[:, None] * a for w, a in parts)
    dq = sum(w * np.cos(w * t)[:, None] * a for w, a in parts)
    return Motion(t, q, dq, 0.0 * q)


def tool_places(arm, q, tool):
    return (flange_pose(arm.chain, q) @ tool)[:, :3, 3]


def hausdorff(a, b):
    """The largest distance of points of one line from the nearest of the other, both ways."""
    between = cdist(a, b)
    return max(between.min(axis=0).max(), between.min(axis=1).max())


def dense(places, count=4000):
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1)))
    return np.stack([np.interp(np.linspace(0, along[-1], count), along, x) for x in places.T], axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "mm"), [(1, 0.2), (2, 2.0)])
def test_any_motion_is_followed_within_the_tolerance(arm, seed, mm):
    motion, tool = fourier(arm, seed), frame_matrix((10, 20, 150, 0, 30, 0))
    written = write_path(path_of_motion(motion, arm, tool), WritingOptions(tolerance=Tolerance(mm / 1e3, 5e-3)))
    assert written.holds
    # by another road: the nearest of many places, both ways
    program = dense(tool_places(arm, written.run.timeline.sample(np.linspace(0, written.run.cycle_time, 8000)).q, tool))
    away = 1e3 * hausdorff(program, dense(tool_places(arm, motion.q, tool)))
    assert 0.1 * mm < away <= mm + 0.05
    assert 1e3 * written.deviation.position == pytest.approx(away, abs=0.1)


@pytest.mark.slow
def test_a_spline_block_takes_fewer_points_and_never_stops(arm):
    path, tolerance = path_of_motion(fourier(arm, 1), arm), Tolerance(1e-3, 1e-2)
    blocks = write_path(path, WritingOptions(tolerance=tolerance, kinds=("LIN", "CIRC", "PTP", "SPL")))
    arcs = write_path(path, WritingOptions(tolerance=tolerance))
    ((kind, count),) = blocks.written.counts().items()
    points = {"LIN": 1, "CIRC": 2, "PTP": 1}
    assert count < sum(points[k] * n for k, n in arcs.written.counts().items())
    assert (kind, blocks.written.passed, blocks.holds) == ("SPL", count - 1, True)
    assert blocks.run.cycle_time < arcs.run.cycle_time
    source = blocks.written.program().source.text()
    assert (source.count("\r\nSPLINE"), source.count("ENDSPLINE")) == (1, 1)


@pytest.mark.slow
def test_an_axis_spline_follows_an_exciting_motion_nearly_in_its_time(arm):
    """Through the wrist singularity, where paths in space cannot go."""
    motion = fourier(arm, 3)
    motion = Motion(motion.t, motion.q - np.array([0, 0, 0, 0, 0.87, 0]), motion.dq, motion.ddq)
    assert motion.q[:, 4].min() < 0.0 < motion.q[:, 4].max()
    options = WritingOptions(tolerance=Tolerance(2e-4, 2e-3), kinds=("SPTP",))
    written = write_path(path_of_motion(motion, arm), options)
    assert written.holds
    assert written.written.passed == written.written.counts()["SPTP"] - 1
    assert written.run.cycle_time < 1.5 * 3.0
    assert "\r\nPTP_SPLINE" in written.written.program().source.text()


def test_a_program_written_from_its_run_has_its_motions_again(arm):
    lines = ("PTP {A1 30, A2 -80, A3 100, A4 10, A5 45, A6 20}", "WAIT SEC 0.5", "LIN_REL {Z -100}",
             "CIRC_REL {X 50, Y 50}, {X 100, Y 0}", "LIN_REL {X 100, B 10}")  # fmt: skip
    run = run_of(arm, HOME, *lines)
    written = write_path(path_of_motion(run.to_run(), arm), WritingOptions(tolerance=Tolerance(2e-4, 1e-3)))
    assert [m.kind for m in written.written.motions] == ["PTP", "LIN", "CIRC", "LIN"]
    statements = [x.statement for x in written.written.program().source.lines]
    found = [written.written.motion_at(i) for i, x in enumerate(statements, 1) if isinstance(x, s.Move)]
    assert found == [-1, 0, 1, 2, 3]
    ends = [x.q for x in run.executed if x.kind != "WAIT"]
    again = [x.q for x in written.run.executed if x.kind != "WAIT"]
    np.testing.assert_allclose(again, ends, atol=np.radians(0.05))
    assert [x.end - x.begin for x in written.run.executed if x.kind == "WAIT"] == pytest.approx([0.5])
    assert written.holds


def test_status_and_turn_lead_back_to_the_axes(arm):
    q = np.radians([[0, -90, 90, 0, 30, 0], [-40, -70, 60, -120, -50, 200], [30, -100, 110, 60, 70, -190]])
    t = np.linspace(0.0, 1.0, 301)
    samples = np.vstack([q[0] + t[:, None] * (q[1] - q[0]), q[1] + t[1:, None] * (q[2] - q[1])])
    times = np.arange(len(samples)) / 100.0
    path = path_of_motion(Motion(times, samples, np.gradient(samples, times, axis=0), 0 * samples), arm)
    written = write_path(path, WritingOptions(kinds=("PTP",), tolerance=Tolerance(1e-3, 1e-2), approximate=False))
    text = written.written.program().data.text()
    assert text.count("DECL E6POS") >= 2
    np.testing.assert_allclose(written.run.executed[-1].q, q[2], atol=1e-6)
    assert written.holds


def test_through_the_wrist_singularity_goes_by_ptp(arm):
    t = np.linspace(0.0, 1.0, 501)
    q = np.radians([0, -90, 90, 0, 40, 0]) + t[:, None] * np.radians([5, 5, 0, 0, -80, 0])
    path = path_of_motion(Motion(t, q, np.gradient(q, t, axis=0), 0 * q), arm)
    motions = fitted_motions(path, (1e-3, 1e-2), ("LIN", "CIRC"))
    crossed = [m.kind for m in motions if path.q[m.first, 4] > 0 >= path.q[m.last, 4]]
    assert crossed == ["PTP"]
    assert write_path(path, WritingOptions(kinds=("LIN", "CIRC"), tolerance=Tolerance(1e-3, 1e-2))).holds


@pytest.mark.slow
def test_a_path_that_nearly_touches_the_reach_runs(arm):
    """An arc in its place would be beyond the reach."""
    t = np.linspace(0.0, 1.0, 801)
    elbow = wrist_arm_geometry(arm.chain).straight + 0.05 + 0.3 * (1.0 + np.cos(6.0 * t))
    q = np.stack([0.6 * t, 0.3 * t - 1.2, elbow, 0.3 + 0 * t, 0.3 * t + 0.9, 0 * t], axis=1)
    path = path_of_motion(Motion(t, q, np.gradient(q, t, axis=0, edge_order=2), 0 * q), arm)
    written = write_path(path, WritingOptions(tolerance=Tolerance(1e-3, 1e-2)))
    assert written.holds
    assert {"PTP", "CIRC"} <= set(written.written.counts())


SQUARE = "X,Y,Z,A,B,C\n0,0,0,0,0,0\n200,0,0,0,0,0\n200,200,0,0,0,0\n0,200,50,0,20,0\n"
FRAMES = {"tool": frame_matrix((0, 0, 100, 0, 0, 0)), "base": frame_matrix((1000, -100, 1400, 0, 90, 0))}


@pytest.fixture
def square(tmp_path):
    (tmp_path / "square.csv").write_text(SQUARE)
    return tmp_path / "square.csv"


def test_corners_are_cut_by_less_than_the_tolerance_and_save_time(arm, square):
    path = read_sampled_path(square, arm, **FRAMES)
    options = WritingOptions(tolerance=Tolerance(1e-3, 1e-2))
    passed, stopped = (write_path(path, replace(options, approximate=x), FRAMES["base"]) for x in (True, False))
    assert [m.kind for m in passed.written.motions] == ["LIN"] * 3
    assert (passed.holds, stopped.holds) == (True, True)
    assert 1e-4 < passed.deviation.position < 1e-3
    assert stopped.deviation.position < 1e-6
    assert passed.run.cycle_time < stopped.run.cycle_time - 0.02
    # d |turn of the direction| / 4 is CUT of the tolerance: 1.13 mm at the right angle, rounded down
    assert passed.written.approximations[0] == Approximation("C_DIS", 1.1)
    source = passed.written.program().source.text()
    assert source.count("C_DIS") == 2
    assert "X 200.0, Y 200.0, Z 0.0" in passed.written.program().data.text()


@pytest.mark.parametrize(("square", "linear", "most"), [(2.0, 3.0, 5.0), (0.0, 4.0, 2.0), (3.0, 0.0, 12.0)])
def test_the_distance_of_a_blend_solves_its_square(square, linear, most):
    d = _root(square, linear, most)
    assert square * d**2 + linear * d == pytest.approx(most)
    assert 0.0 < d < _root(0.0, 0.0, most) == np.inf


def test_a_program_that_is_somewhere_else_is_seen(arm, square):
    path = read_sampled_path(square, arm, **FRAMES)
    written = write_path(path, WritingOptions(approximate=False), FRAMES["base"])
    shifted = (frame_matrix((0, 0, 3, 0, 0, 0)) @ path.T)[:, :, :]
    other = type(path)(arm, path.q, shifted, path.tool, None, "shifted")
    found = path_deviation(other, written.written.motions, written.run, Tolerance())
    assert found.position == pytest.approx(3e-3, rel=1e-3)
    assert not found.holds(Tolerance())
    turned = type(path)(arm, path.q, path.T @ frame_matrix((0, 0, 0, 1, 0, 0)), path.tool, None, "turned")
    found = path_deviation(turned, written.written.motions, written.run, Tolerance())
    assert (found.position, found.orientation) == pytest.approx((0.0, np.radians(1.0)), rel=1e-3, abs=1e-6)


def test_a_path_in_space_reaches_up_to_where_it_must_be_ptp(arm, square):
    path = read_sampled_path(square, arm, **FRAMES)
    last = len(path.q) - 1
    assert _reach(path, 1e-3, [(3, 5)]).tolist() == [3] * 4 + [4] + [last] * (last - 4)
    assert _reach(path, 1e-3, ()).tolist() == [last] * (last + 1)


def test_a_speed_that_an_axis_cannot_keep_is_lowered(arm, square):
    path = read_sampled_path(square, arm, **FRAMES)
    fast = write_path(path, WritingOptions(speed=10.0), FRAMES["base"])
    assert max(fast.written.speeds.cp) < 10.0
    assert not [d for d in fast.run.diagnostics if d.code == "axis-speed"]


def test_a_program_is_slowed_until_no_axis_is_over_its_speed_and_no_more(arm, square):
    slow = replace(arm, limits=tuple(replace(x, velocity=x.velocity / 4) for x in arm.limits))
    path = read_sampled_path(square, slow, **FRAMES)
    program = write_path(path, WritingOptions(approximate=False), FRAMES["base"]).written
    speeds = ProgramSpeeds(50, (1.0, 1.0, 1.0), 90.0)
    found, run = _slow_enough(replace(program, speeds=speeds), None)
    factor = found.speeds.cp[0]
    assert math.log(factor, 0.8) == pytest.approx(round(math.log(factor, 0.8)))
    assert astuple(found.speeds) == (int(50 * factor), (factor,) * 3, pytest.approx(90 * factor))
    assert (factor < 1.0, [d for d in run.diagnostics if d.code == "axis-speed"]) == (True, [])
    with pytest.raises(ProgramError, match="would have to turn at"):
        run_program(replace(program, speeds=speeds.slower(factor / 0.8)).program(), slow)
    assert astuple(speeds.slower(0.001)) == (1, (0.001,) * 3, 0.09)
    assert astuple(ProgramSpeeds(50, (1.0,)).slower(0.5)) == (25, (0.5,), None)


def test_where_a_path_in_space_is_impossible_it_is_ptp(arm):
    t = np.linspace(0.0, 1.0, 51)
    q = np.radians([0, -90, 90, 0, 40, 0]) + t[:, None] * np.radians([5, 5, 0, 0, -80, 0])
    path = path_of_motion(Motion(t, q, np.gradient(q, t, axis=0), 0 * q), arm)
    asked, last = [], len(path.q) - 1

    def candidate(only_ptp):
        asked.append(list(only_ptp))
        motions = (FittedMotion("PTP" if only_ptp else "LIN", 0, last),)
        return PathProgram("a", path, motions, speeds_of(path, motions, 0.01, 10), (None,), np.eye(4))

    program, run = _possible(candidate, None)
    assert (asked, [x.kind for x in program.motions]) == ([[], [(0, last)]], ["PTP"])
    np.testing.assert_allclose(run.executed[-1].q, path.q[-1], atol=1e-5)


def test_the_command_writes_prints_and_is_run_again(square, folder, printed):
    frames = ("--tool-data", "0,0,100,0,0,0", "--base-data", "1000,-100,1400,0,90,0")
    out = printed("krl", "write", "square.csv", *frames, "--tolerance-mm", "1")
    assert "3 LIN; 2 of 2 points are passed without a stop" in out
    printed("krl", "run", "square.src", "--out", "square.npz")
    options = ("--tolerance-mm", "2", "--out", "b.src", "--tool-number", "3", "--motions", "lin,circ,ptp")
    out = printed("krl", "write", "square.npz", *frames, *options)
    assert 'TOOL_DATA[3]={X 0.0, Y 0.0, Z 100.0, A 0.0, B 0.0, C 0.0}\nTOOL_NAME[3,]="b"' in out
    assert "BAS(#TOOL, 3)" in (folder / "b.src").read_text()


WRONG = {
    ("--motions", "LIN,FLY"): "kinds: LIN,FLY; allowed: some of LIN, CIRC, PTP, SPL, SPTP",
    ("--motions", "LIN,SPTP"): "kinds: LIN,SPTP; allowed: SPTP alone",
    ("--angle-tolerance-deg", "0"): "tolerance: 0 deg; allowed: from 0.001 to 57 deg",
    ("--tolerance-mm", "0"): "tolerance: 0 mm; allowed: from 0.001 to 1000 mm",
    ("--tool-data", "1,2"): "--tool-data: 1,2; allowed: six numbers",
    ("--out", "if.src"): "name: 'if'; allowed: a name of KRL",
    ("--out", "a.txt"): "not the name of a program; allowed: a path that ends in .src",
}


def test_a_wrong_option_is_one_line(square, folder, refused):
    for options, message in WRONG.items():
        assert message in refused("krl", "write", "square.csv", *options)


ONE_WAY = {
    ("SPL",): ({"SPL": 9}, 0.8658434, 0.5113038),
    ("SPTP",): ({"SPTP": 8}, 0.4412708, 0.2922157),
    ("LIN", "CIRC", "PTP", "SPL"): ({"CIRC": 1, "SPL": 6}, 1.1624771, 0.4084674),
    ("LIN", "CIRC", "PTP"): ({"CIRC": 4, "LIN": 1}, 1.1646909, 0.4053187),
}
"""What a way of 0.2 s takes, by the statements allowed: motions, the program's time [s], how far off it is [mm]."""


@pytest.mark.parametrize("kinds", ONE_WAY, ids="-".join)
def test_a_short_way_takes_few_points(arm, kinds):
    motion = fourier(arm, 1, 1.0)
    short = Motion(*(x[:300:3] for x in (motion.t, motion.q, motion.dq, motion.ddq)))
    written = write_path(path_of_motion(short, arm), WritingOptions(tolerance=Tolerance(1e-3, 1e-2), kinds=kinds))
    counts, seconds, millimetres = ONE_WAY[kinds]
    assert written.holds
    assert written.written.counts() == counts
    assert (written.run.cycle_time, 1e3 * written.deviation.position) == pytest.approx((seconds, millimetres), rel=1e-5)
