"""Proofs of the errata of published sets: all hold, each needs its own erratum, and a changed cell ends them."""

import json

import pytest
from click.testing import CliRunner

from lwr_dyn.arms.papers.catalog import open_paper, published
from lwr_dyn.cli.reproduce import command
from lwr_dyn.reproduction import published_sets
from lwr_dyn.reproduction.published_sets import PROOFS, arm_with, reproduced_sets, set_ledger, triangle

CORRECTIONS = [
    ("panda", "link7-frame"), ("panda", "link1-centre"), ("puma560", "link4-centre-sign"),
    ("stanford", "centres-tenfold"),
]  # fmt: skip
"""Errata whose proof reads cells with them."""


@pytest.mark.parametrize("robot", published())
def test_every_proven_erratum_has_a_proof_that_holds(robot):
    entries = set_ledger(robot)
    assert [e.erratum.id for e in entries if not e.holds] == []
    assert {e.erratum.id for e in entries if e.proof is not None} == set(PROOFS.get(robot, {}))
    assert all(e.proof is None or e.proof.numbers for e in entries)


@pytest.mark.parametrize(("robot", "erratum"), CORRECTIONS)
def test_a_proof_fails_without_its_own_erratum(robot, erratum, monkeypatch):
    def without(name, *errata, **options):
        return arm_with(name, *(x for x in errata if x != erratum), **options)

    monkeypatch.setattr(published_sets, "arm_with", without)
    assert not PROOFS[robot][erratum]().holds


STATED = {
    "fer-link4-triangle": (0.0946, -0.0354, -0.1076), "link7-frame": (0.9735, 0.0), "link1-centre": (-0.04762, 0.0),
    "link4-centre-sign": (0.3056, 0.0), "centres-tenfold": (6.447, 0.6447, 0.965),
    "moments-about-origins": (2.51, 4.25 * (0.965 / 2) ** 2, 4.25 * 0.965**2), "tensors-of-ur10": (6, 0),
    "mamedov-edge": (0.0,),
}  # fmt: skip


def test_proofs_state_their_numbers():
    found = {name: tuple(proof().numbers.values()) for proofs in PROOFS.values() for name, proof in proofs.items()}
    assert found == {name: pytest.approx(numbers, abs=1e-4) for name, numbers in STATED.items()}


CHANGED = {
    "fer-link4-triangle": {
        "[[0.00784585566, -0.00339591957": "[[0.00784585566, 0", "[-0.00339591957, 0.00649543136": "[0, 0.00649543136"
    },
    "moments-about-origins": {"2.51": "0.51"},
}  # fmt: skip
"""Erratum -> cells with which there would be none."""


@pytest.mark.parametrize("erratum", CHANGED)
def test_a_proof_fails_where_the_cell_is_another(erratum, monkeypatch):
    robot = next(name for name, proofs in PROOFS.items() if erratum in proofs)

    def changed(name, *errata, of="", change=None):
        return arm_with(name, *errata, of=of, change=CHANGED[erratum])

    monkeypatch.setattr(published_sets, "arm_with", changed)
    assert not PROOFS[robot][erratum]().holds


def test_a_set_that_is_well_inside_what_bodies_have_is_not_at_its_edge(monkeypatch):
    monkeypatch.setattr(published_sets, "arm_with", lambda robot, **_: arm_with(robot))
    assert abs(triangle(arm_with("ur10e"), 1)) > 0.01
    assert not PROOFS["ur10e"]["mamedov-edge"]().holds


def test_tensors_of_another_robot_are_no_copies(monkeypatch):
    monkeypatch.setattr(published_sets, "open_paper", lambda robot: open_paper("ur5e" if robot == "ur10e" else robot))
    assert not PROOFS["ur10e"]["tensors-of-ur10"]().holds


def test_the_command_shows_statement_and_numbers_and_fails_with_a_proof(tmp_path, monkeypatch):
    result = CliRunner().invoke(command, ["puma560", "--out", str(tmp_path / "a")])
    assert result.exit_code == 0, result.output
    assert "with the sign turned gravity is that of the set akb" in result.output
    assert "Of 3 errata 1 is proven." in result.output
    record = json.loads((tmp_path / "a" / "results.json").read_text())
    assert (record["holds"], record["numbers"]) == (True, [])
    shown = {e["id"]: e["proof"] for e in record["errata"]}
    assert shown["link4-centre-sign"]["kind"] == "correction"
    assert shown["link3-moment"] is None
    monkeypatch.setattr(published_sets, "ELBOW_UP", 0.0)
    failed = reproduced_sets("puma560", tmp_path / "b")
    assert not failed.holds
    assert "DOES NOT HOLD" in failed.document.text()
