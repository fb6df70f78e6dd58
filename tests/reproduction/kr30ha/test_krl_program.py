"""The report's program: every fault found, no other; the corrected one clean, at its points and back."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.krl.project.program import load_program, parse_program
from lwr_dyn.krl.running.program_run import check_program
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.kr30ha.krl_program import (
    EXACT_MM,
    printed_program,
    program_parts,
    program_report,
    write_program,
)
from lwr_dyn.reproduction.papers import printed_tables


@pytest.fixture(scope="module")
def arm():
    return lwr_dyn.load("kr30ha")


@pytest.fixture(scope="module")
def report(arm):
    return program_report(arm)


def test_the_lines_are_those_of_the_printed_program():
    lines = printed_program().source.text().splitlines()
    assert [lines[i - 1].split()[1] for i in (13, 14, 15)] == ["Point1", "Point2", "MasteringPos"]
    assert lines[19] == "PTP Mastering"
    faults = printed_tables("kr30ha", "program")["fault"]
    assert {line for f in faults for line in f["lines"]} == {13, 14, 15, 20, 24, 28, 32}


def test_each_repair_takes_its_own_fault_away(arm):
    text = printed_program().source.text()
    repaired = text.replace("PTP Mastering\n", "PTP MasteringPos\n")
    assert "undeclared" not in {d.code for d in check_program(parse_program(repaired), arm)}
    typed = text.replace("DECL Point", "DECL E6POS Point").replace("DECL Mast", "DECL E6POS Mast")
    assert "missing-type" not in {d.code for d in check_program(parse_program(typed), arm)}
    moved = text.replace(
        "{X 0, Y 0, Z 0, A 0, B 0, C 0}\n\n; Call", "{A1 0, A2 -90, A3 90, A4 0, A5 0, A6 0}\n\n; Call"
    )
    assert not {"inside-robot", "outside-limits"} & {d.code for d in check_program(parse_program(moved), arm)}


def test_the_corrected_program_is_clean_and_goes_where_it_should(report, arm):
    assert report.missing == report.false == report.left == ()
    assert [s.target_mm for s in report.points] == [(91, -1139, 1392), (91, -1117, 1447)]
    T = [lwr_dyn.forward_kinematics(arm, d.q) for d in report.run.executed if d.kind == "PTP"][:2]
    for stop, pose in zip(report.points, T, strict=True):
        assert np.linalg.norm(1e3 * pose[:3, 3] - stop.target_mm) <= EXACT_MM
        assert stop.missed_mm <= EXACT_MM
        assert np.abs(pose[:3, :3] - np.eye(3)).max() < 1e-12
    assert np.abs(np.degrees(report.run.motion.q[-1]) - [0, -90, 90, 0, 0, 0]).max() < 1e-12
    assert report.holds


def test_the_diagnosis_and_the_run_in_words_and_in_the_record(report):
    note, run = program_parts(report)
    faults = len(report.printed)
    assert note.lines[0] == f"The report's program (Appendix B): {faults} diagnoses, 0 known faults missed, 0 false"
    assert list(note.lines[1:]) == [str(d) for d in report.printed]
    assert run.title == f"The corrected program: 0 diagnoses, cycle {report.run.duration:.3f} s"
    assert [row[:3] for row in run.rows] == [
        ("Point1", "91, -1139, 1392", "S 4 T 52"), ("Point2", "91, -1117, 1447", "S 4 T 52"),
    ]  # fmt: skip
    right = report.record()["corrected"]
    stops = [{"point": p.name, "missed_mm": p.missed_mm, "s": p.s, "t": p.t} for p in report.points]
    assert (right["diagnoses"], right["cycle_time"], right["stops"]) == ([], report.run.cycle_time, stops)
    far = replace(report.points[0], missed_mm=2e-6)
    for change in ({"missing": ((1, "a", "b"),)}, {"false": ((1, "a", "b"),)}, {"left": report.printed},
                   {"points": (far,)}, {"home_missed": 2e-12}):  # fmt: skip
        assert not replace(report, **change).holds


def test_what_is_written_is_read_and_runs_again(report, arm, tmp_path):
    write_program(report, arm, tmp_path)
    names = {p.name for p in tmp_path.iterdir()}
    assert {"TwoPointMotionPath.src", "TwoPointMotionPath.dat", "diagnosis.txt", "replay.html"} <= names
    assert b"\r\n" in (tmp_path / "TwoPointMotionPath.src").read_bytes()
    again = load_program(tmp_path / "TwoPointMotionPath.src")
    assert again.source == report.corrected.source
    assert again.data == report.corrected.data
    stored = Run.load(tmp_path / "TwoPointMotionPath.npz")
    assert np.array_equal(stored.q, report.run.motion.q)
