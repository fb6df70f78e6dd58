"""What `lwr-dyn sweep` says of chunks that were made, were there, or failed."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from lwr_dyn.cli.sweep import sweep_document
from lwr_dyn.foundation.document import Section

STUDY = SimpleNamespace(name="small", runs=4, controllers=("pd", "id"))


def outcome(made, kept, failures):
    return SimpleNamespace(
        made=made, kept=kept, failures=failures, seconds=1.5, folder=Path("out"),
        is_complete=not any(failures.values()), refused=(),
        cost=SimpleNamespace(section=lambda: Section("", [], "cost")),
    )  # fmt: skip


NONE = {"pd": {}, "id": {}}
FAILED = {"pd": {}, "id": {7: "no disk", 3: "no memory"}}


@pytest.mark.parametrize(
    ("made", "kept", "failures", "said"),
    [
        ((2, 1), (0, 0), NONE, ["made 3 chunks in 2 s: out"]),
        ((2, 0), (0, 1), NONE, ["made 2 chunks in 2 s, 1 were there: out"]),
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
    done = outcome(
        dict(zip(STUDY.controllers, made, strict=True)), dict(zip(STUDY.controllers, kept, strict=True)), failures
    )
    document = sweep_document(STUDY, done, None)
    assert [line for line in document.text().splitlines() if line] == said
    record = document.record()
    assert {key: record[key] for key in ("study", "folder", "runs", "complete", "report", "worst")} == {
        "study": "small", "folder": "out", "runs": 4, "complete": failures is NONE, "report": None, "worst": [],
    }  # fmt: skip
    assert [(x["controller"], x["made"], x["kept"]) for x in record["controllers"]] == [
        ("pd", made[0], kept[0]), ("id", made[1], kept[1]),
    ]  # fmt: skip
    assert [x["failures"] for x in record["controllers"]] == [
        [{"chunk": k, "why": each[k]} for k in sorted(each)] for each in failures.values()
    ]
