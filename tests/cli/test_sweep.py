"""`lwr-dyn sweep`: what is typed reaches the study; what it says of chunks that were made, were there, or failed."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from lwr_dyn.cli.sweep import sweep_document
from lwr_dyn.foundation.document import Section

STUDY = SimpleNamespace(name="small", runs=4, controllers=("pd", "id"))
NONE = {"pd": {}, "id": {}}
FAILED = {"pd": {}, "id": {7: "no disk", 3: "no memory"}}
FILE = """robot = "lwr4plus"
controllers = ["pd-gravity"]
[task]
name = "hold"
from-deg = [0, 30, 0, -60, 0, 30, 0]
duration = 0.05
[[parameter]]
path = "payload.mass"
low = 0
high = 1
"""


def outcome(made=(1, 0), kept=(0, 0), failures=NONE, refused=()):
    return SimpleNamespace(
        made=dict(zip(STUDY.controllers, made, strict=True)), kept=dict(zip(STUDY.controllers, kept, strict=True)),
        failures=failures, seconds=1.5, folder=Path("out"), is_complete=not any(failures.values()), refused=refused,
        cost=SimpleNamespace(section=lambda: Section("", [], "cost")),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("made", "kept", "failures", "said"),
    [
        ((2, 1), (0, 0), NONE, ["made 3 chunks in 2 s: out"]),
        ((1, 0), (0, 1), NONE, ["made 1 chunk in 2 s, 1 were there: out"]),
        ((0, 0), (2, 1), NONE, ["all 3 chunks were there: out"]),
        ((2, 0), (0, 1), FAILED, [
            "made 2 chunks in 2 s, 1 were there: out", "FAILED: id, chunk 3, no memory", "FAILED: id, chunk 7, no disk",
            "2 chunks failed; the same command tries again"]),
        ((0, 0), (0, 1), {"pd": {0: "x"}, "id": {}}, [
            "made 0 chunks in 2 s, 1 were there: out", "FAILED: pd, chunk 0, x",
            "1 chunk failed; the same command tries again"]),
    ],
)  # fmt: skip
def test_chunks(made, kept, failures, said):
    document = sweep_document(STUDY, outcome(made, kept, failures), None)
    assert [line for line in document.text().splitlines() if line] == said
    record = document.record()
    assert {key: record[key] for key in ("study", "folder", "runs", "complete", "seconds", "report", "worst")} == {
        "study": "small", "folder": "out", "runs": 4, "complete": failures is NONE, "seconds": 1.5, "report": None,
        "worst": [],
    }  # fmt: skip
    assert [tuple(x.values()) for x in record["controllers"]] == [
        (name, made[k], kept[k], [{"chunk": c, "why": failures[name][c]} for c in sorted(failures[name])])
        for k, name in enumerate(STUDY.controllers)
    ]


def test_files_of_a_report_and_runs_that_are_refused_are_named():
    finished = SimpleNamespace(page="out/report.html", worst=("a.html", "b.html"), summary=None)
    document = sweep_document(STUDY, outcome(refused=("pd: left out",)), finished)
    assert [line for line in document.text().splitlines() if line] == [
        "made 1 chunk in 2 s: out", "pd: left out", "wrote out/report.html", "wrote a.html", "wrote b.html",
    ]  # fmt: skip
    record = document.record()
    assert (record["report"], record["worst"]) == ("out/report.html", ["a.html", "b.html"])


@pytest.mark.parametrize(
    ("options", "expected", "finished", "code"),
    [
        ((), (16, {"scheduler": None, "threads": None}), True, 0),
        (("--runs", "32", "--jobs", "2", "--scheduler", "tcp://x:1", "--no-report"),
         (32, {"scheduler": "tcp://x:1", "threads": 2}), False, 1),
    ],
)  # fmt: skip
def test_what_is_typed_reaches_the_sweep(asked, lwr_dyn_command, folder, options, expected, finished, code):
    (folder / "s.toml").write_text(FILE.replace("[[parameter]]", "[sampling]\nruns = 16\n[[parameter]]"))
    made = asked("lwr_dyn.cli.sweep.sweep", outcome(failures={"pd": {}, "id": {1: "x"} if code else {}}))
    results = asked("lwr_dyn.studies.sweep.running.sweep_folder.SweepResults.load", "results")
    ended = asked("lwr_dyn.cli.sweep.finish")
    shown = asked("lwr_dyn.cli.sweep.sweep_document", sweep_document(STUDY, outcome(), None))
    assert lwr_dyn_command("sweep", "s.toml", "--out", "made", *options)[0] == code
    (study, out), given = made[0]
    assert (out, study.runs, {name: given[name] for name in ("scheduler", "threads")}) == ("made", *expected)
    assert (len(ended), len(results)) == (finished, finished)
    assert shown[0][0][0] is study
