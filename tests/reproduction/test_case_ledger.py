"""The errata ledger: each proven fault has a proof that runs and holds, and that fails where the fault is absent."""

import copy

import pytest

from lwr_dyn.arms.papers.schema import SEVERITIES
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.reproduction.case import LedgerEntry, PaperData, Proof, ledger
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import results_of_tables, studies

ALL = [(paper, erratum) for paper in studies() for erratum in paper_study(paper).data.errata]
PROVEN = [(paper, erratum) for paper, erratum in ALL if erratum.status == "proven"]
PROMISED = 25
LONG = {"table1-swapped-yz", "table2-c5z", "table2-rows", "com-from", "table4-configurations", "planar-model"}
"""Errata whose proofs search for maxima or derive equations."""


def each(chosen):
    """Parameters: paper and erratum, those with long proofs slow."""
    return [
        pytest.param(paper, e, id=f"{paper}-{e.id}", marks=[pytest.mark.slow] * (e.id in LONG)) for paper, e in chosen
    ]


@pytest.mark.parametrize(("paper", "erratum"), each(PROVEN))
def test_a_proven_erratum_has_a_proof_that_holds(paper, erratum):
    study = paper_study(paper)
    proof = study.proofs[erratum.id](study.data)
    assert proof.holds, proof.text
    assert proof.statement
    assert "\n" not in proof.statement


def test_the_ledger_has_every_erratum_with_its_proof():
    study = paper_study("wam7")
    entries = ledger(study.data, study.proofs)
    assert [e.erratum for e in entries] == list(study.data.errata)
    assert [e.erratum.id for e in entries if e.proof is not None] == list(study.proofs)
    assert all(e.holds for e in entries)


def test_there_are_as_many_as_promised_and_no_proof_is_of_nothing():
    assert len(PROVEN) >= PROMISED
    assert len({paper for paper, _ in PROVEN}) == 3  # the exercise has no fault that its text shows
    for paper in studies():
        assert set(paper_study(paper).proofs) <= {e.id for e in paper_study(paper).data.errata}


def test_every_entry_has_a_severity():
    assert {erratum.severity for _, erratum in ALL} == set(SEVERITIES)


def test_a_proven_entry_without_a_proof_or_with_a_broken_one_does_not_hold():
    _, erratum = PROVEN[0]
    assert not LedgerEntry(erratum, None).holds
    assert not LedgerEntry(erratum, Proof("nothing", False)).holds
    likely = next(e for _, e in ALL if e.status == "likely")
    assert LedgerEntry(likely, None).holds


def without_the_fault(paper, erratum):
    """The paper as it would be had it printed what the erratum reads."""
    here = paper_study(paper)
    tables, results = copy.deepcopy(dict(here.data.tables)), copy.deepcopy(dict(here.data.results.raw))
    for patch in erratum.patches:
        steps = patch.at.replace("]", "").replace("[", ".").split(".")
        if steps[0] == "results":
            block = results[steps[1]]
            holder, steps = block["cells"] if steps[2] in block["cells"] else block["given"], steps[2:]
        else:
            holder = tables
        for step in steps[:-1]:
            holder = holder[int(step) if step.isdigit() else step]
        last = int(steps[-1]) if steps[-1].isdigit() else steps[-1]
        assert holder[last] == patch.printed
        holder[last] = patch.read
    for entry in tables["erratum"]:
        if entry["id"] == erratum.id:
            entry.pop("patch")
    return PaperData(tables, results_of_tables(results, "results.toml"), here.data.file)


PATCHED = [(paper, e) for paper, e in PROVEN if e.patches]


@pytest.mark.parametrize(("paper", "erratum"), each(PATCHED))
def test_the_proof_fails_on_a_paper_that_prints_what_is_right(paper, erratum):
    evidence = without_the_fault(paper, erratum)
    try:
        holds = paper_study(paper).proofs[erratum.id](evidence).holds
    except LwrDynError:
        return  # nothing left to compare
    assert not holds
