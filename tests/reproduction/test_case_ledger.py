"""The errata ledger: each proven fault has a proof that runs and holds, and that fails where the fault is absent.

Where a fault has no cell to put right, the data or the computation of its proof is broken once.
"""

import copy
import dataclasses
import math
from functools import cache

import numpy as np
import pytest

from lwr_dyn.arms.papers.schema import SEVERITIES
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.reproduction.case import CONTRADICTION, KINDS, LedgerEntry, PaperData, Proof, ledger
from lwr_dyn.reproduction.kr30ha import formulas, krl_program, matrices, planar_dynamics
from lwr_dyn.reproduction.kr30ha.planar_dynamics import planar_equations
from lwr_dyn.reproduction.lwr4plus import proofs
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import printed_tables, results_of_tables, studies
from lwr_dyn.reproduction.wam7 import formulas as wam7_formulas

ALL = [(paper, erratum) for paper in studies() for erratum in paper_study(paper).data.errata]
PROVEN = [(paper, erratum) for paper, erratum in ALL if erratum.status == "proven"]
PROMISED = 25


def each(chosen):
    """Parameters: paper and erratum."""
    return [pytest.param(paper, e, id=f"{paper}-{e.id}") for paper, e in chosen]


@cache
def proved(paper, name):
    """A proof, run once."""
    return paper_study(paper).proofs[name](paper_study(paper).data)


@pytest.mark.parametrize(("paper", "erratum"), each(PROVEN))
def test_a_proven_erratum_has_a_proof_that_holds(paper, erratum):
    proof = proved(paper, erratum.id)
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


def with_likely_errata_unread(paper):
    """The paper's data where an erratum that is only likely changes nothing."""
    here = paper_study(paper)
    tables = copy.deepcopy(dict(here.data.tables))
    for entry in tables["erratum"]:
        if entry["status"] == "likely":
            for patch in entry.get("patch", ()):
                patch["read"] = copy.deepcopy(patch["printed"])
    return PaperData(tables, here.data.results, here.data.file)


@pytest.mark.parametrize(("paper", "erratum"), each((p, e) for p, e in PROVEN if p != "kr30ha"))  # it has none likely
def test_no_proof_rests_on_an_erratum_that_is_only_likely(paper, erratum):
    proof = paper_study(paper).proofs[erratum.id](with_likely_errata_unread(paper))
    assert proof.holds, proof.text


@cache
def numbers_by_other_roads():
    """What proofs state, from the printed numbers by hand; with five digits what only a recursion gives."""
    tables = printed_tables("lwr4plus")
    b = [float(x) for x in tables["table_iv"]["b"]]
    m, r, (omega, xi) = tables["rotor_inertia"]["m"], tables["rotor_inertia"]["r"], (50.0, 1.0)
    case = paper_study("lwr4plus").data.case("table2-rows")
    k, I7 = case.values("rotors", "gear_ratio")[6], case.values("inertial", "inertia")[6][2][2]
    right, one = 0.0, math.atan2(1139, 91)
    return {
        ("lwr4plus", "table2-rows"): [0.4, right],
        ("lwr4plus", "rotor-inertia-power"): [m * r**2 / 2, 1.325e-7, I7 + k**2 * 1.325e-7, I7 + k**2 * m * r**2 / 2],
        ("lwr4plus", "table6-exchanged"): [omega**2 * b[6], 2 * xi * omega * b[5]],
        ("lwr4plus", "table8-velocity-order"): ["[2, 3, 4, 5, 6]"],
        ("lwr4plus", "largest-error-side"): [0.0204, 0.0338, "[0.017, 0.0301]"],
        ("lwr4plus", "conclusion-errors"): ["[2, 3, 5]", "[1, 6, 7]"],
        ("lwr4plus", "coriolis-vector"): [4.0, right],
        ("lwr4plus", "n-without-dq"): [right, 1.04453],
        ("lwr4plus", "moment-omega"): [right, 0.23056, k**2 * 1.325e-7, k**2 * 1.325e-7],
        ("lwr4plus", "torque-transposes"): [right, 67.321],
        ("lwr4plus", "outer-loop-q"): [0.5, -12.5, 2500 * (0.5 - 1.0) / 100],
        ("lwr4plus", "error-second-derivative"): [right, 2500.0, -2500 / 101],
        ("lwr4plus", "pid-is-pd"): [10.0 / 7310, 10.0 / 7310, right],
        ("lwr4plus", "table2-c5z"): [-2e-9, -0.0238, -0.0238],
        ("lwr4plus", "table1-swapped-yz"): ["['xzy xzy']"],
        ("lwr4plus", "com-from"): [2.92334, 1.91799, 0.002193, 0.346001],
        ("lwr4plus", "table4-configurations"): [
            "0.9798 to 2.923", "2.895 to 2.897", "0.03192 to 0.03192", "0.4637 to 0.4649", "0.00953 to 0.01024",
        ],
        ("wam7", "products-sign"): [4.953e-8, 4.99224e-3],
        ("wam7", "home-outside"): ["[4]", 0.03],
        ("wam7", "lspb-velocity"): [0.075, right],
        ("wam7", "figure4-acceleration"): [3, 6],
        ("kr30ha", "table2-offset"): [850 * math.sqrt(2), right],
        ("kr30ha", "table2-half-turn"): [4, 0, 2, 0],
        ("kr30ha", "kuka-signs"): [27.95844, 27.24275, "27.24"],
        ("kr30ha", "symbolic-signs"): [12, 0],
        ("kr30ha", "symbolic-a2"): [3, 0],
        ("kr30ha", "composition-order"): [math.sin(0.4), right],
        ("kr30ha", "mastering-transform"): [right, 850 * math.sqrt(2)],
        ("kr30ha", "home-x"): [350 + 820, 350 + 820 + 170, 1310],
        ("kr30ha", "theta1-offset"): [-math.degrees(one), -math.degrees(math.atan2(1139, 91 - 350)), None],
        ("kr30ha", "elbow-offset"): [850, math.hypot(145, 820), "995, 820"],
        ("kr30ha", "target-frame"): [170, right],
        ("kr30ha", "link-two-820"): [850 + 145, 820, 820],
        ("kr30ha", "unfinished"): [12, 6],
        ("kr30ha", "krl-status-turn"): ["24, 28, 32", 6, 6],
        ("kr30ha", "krl-mastering-cartesian"): ["32", "32", math.hypot(350 + 820 + 170, 815 + 850 + 145)],
        ("kr30ha", "loop-in-text"): [34, 0],
    }  # fmt: skip


@pytest.mark.parametrize(("paper", "name"), [pytest.param(*key, id="-".join(key)) for key in numbers_by_other_roads()])
def test_a_proof_states_the_numbers_that_it_rests_on(paper, name):
    wanted = numbers_by_other_roads()[paper, name]
    for found, value in zip(proved(paper, name).numbers.values(), wanted, strict=True):
        if value is not None:
            assert found == (value if isinstance(value, str) else pytest.approx(value, rel=1e-4, abs=1e-9))


def test_what_two_statements_that_exclude_each_other_leave_open_is_said():
    found = {e.id: proved(p, e.id).kind for p, e in PROVEN}
    assert set(found.values()) <= set(KINDS)
    assert sorted(name for name, kind in found.items() if kind == CONTRADICTION) == [
        "conclusion-errors", "home-outside", "largest-error-side", "link-two-820", "loop-in-text", "pid-is-pd",
        "table8-velocity-order",
    ]  # fmt: skip
    assert Proof("s", True, {"x": 1.0}, CONTRADICTION).text.splitlines() == ["s", "x: 1", KINDS[CONTRADICTION]]
    assert Proof("s", True, {"x": 1.0}).text.splitlines() == ["s", "x: 1"]


def place_of(path, tables, results):
    """What holds the value of a path such as "dh.a.values.0" or "results.BLOCK.cells.Kp.0", and its key there."""
    *steps, last = (int(step) if step.isdigit() else step for step in path.split("."))
    holder = results if steps[0] == "results" else tables
    for step in steps[steps[0] == "results" :]:
        holder = holder[step]
    return holder, last


def without_the_fault(paper, erratum):
    """The paper as it would be had it printed what the erratum reads."""
    here = paper_study(paper)
    tables, results = copy.deepcopy(dict(here.data.tables)), copy.deepcopy(dict(here.data.results.raw))
    for patch in erratum.patches:
        path = patch.at.replace("]", "").replace("[", ".")
        if path.startswith("results."):
            _, name, column = path.split(".")[:3]
            path = path.replace(f"{name}.", f"{name}.{'cells' if column in results[name]['cells'] else 'given'}.", 1)
        holder, last = place_of(path, tables, results)
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


def put(path, value):
    """A change of one value of the data file, or of "results.BLOCK..."."""

    def change(tables, results, _):
        holder, last = place_of(path, tables, results)
        holder[last] = value

    return change


def both(*changes):
    return lambda *arguments: [change(*arguments) for change in changes]


def instead(module, name, value):
    return lambda _, __, patch: patch.setattr(module, name, value)


def without_faults(_, __, patch):
    right = proofs.printed_torque
    patch.setattr(proofs, "printed_torque", lambda chain, q, dq, ddq, errata=(): right(chain, q, dq, ddq))


def nothing_added(_, __, patch):
    found = planar_dynamics.own_comparisons()
    empty = [dataclasses.replace(c, added={e: 0 * m for e, m in c.added.items()}) for c in found]
    patch.setattr(planar_dynamics, "own_comparisons", lambda: empty)


def the_label_was_right(_, __, patch):
    found = {c.name: c for c in planar_dynamics.own_comparisons()}
    found["L"] = dataclasses.replace(found["L"], printed=found["K_TOTAL"].printed)
    patch.setattr(planar_dynamics, "own_comparisons", found.values)


def all_alike(_, __, patch):
    right = planar_dynamics.counterparts
    patch.setattr(planar_dynamics, "counterparts", lambda arm: [dataclasses.replace(c, why="") for c in right(arm)])


def in_order(_, results, __):
    cells = results["table_viii"]["cells"]
    pairs = zip(cells["velocity_maximum"], cells["velocity_minimum"], strict=True)
    ordered = [sorted(pair, key=float) for pair in pairs]
    cells["velocity_minimum"], cells["velocity_maximum"] = map(list, zip(*ordered, strict=True))


LOOP = parse_program(b"DEF a()\nLOOP\nENDLOOP\nEND\n" + b"; line\n" * 40, None, "a")
SILENT = instead(krl_program, "_diagnoses", lambda corrected: ())
FINISHED = instead(planar_dynamics, "finished", lambda lagrangian: planar_equations().tau)
ONES = instead(proofs, "STATE", proofs.STATE | {"dq": np.ones(7)})
BROKEN = {
    ("lwr4plus", "n-without-dq"): ONES,
    ("lwr4plus", "moment-omega"): without_faults,
    ("lwr4plus", "torque-transposes"): without_faults,
    ("lwr4plus", "com-from"): put("dh.d.values", [0.0] * 7),
    ("lwr4plus", "outer-loop-q"): put("results.centralized_gains.cells.Kp.0", "0"),
    ("lwr4plus", "error-second-derivative"): put("results.centralized_gains.cells.Kd.0", "10"),
    ("lwr4plus", "pid-is-pd"): put("results.table_vi.cells.Kd.0", "2.0"),
    ("lwr4plus", "table8-velocity-order"): in_order,
    ("lwr4plus", "largest-error-side"): put("results.table_vii.cells.minimum.1", "-1.0"),
    ("lwr4plus", "conclusion-errors"): put("results.table_viii.cells.average", ["0.1"] * 7),
    ("wam7", "home-outside"): put("results.home.given.q.3", 3.0),
    ("wam7", "lspb-velocity"): put("results.motion.cells.travel.0", "0.0"),
    ("kr30ha", "composition-order"): both(put("dh.alpha.values.0", 0), put("dh.a.values.0", 0)),
    ("kr30ha", "mastering-transform"): put("results.mastering_flange.cells.position", ["1340", "0", "1810"]),
    ("kr30ha", "theta1-offset"): put("dh.a.values.0", 0),
    ("kr30ha", "elbow-offset"): put("dh.a.values.2", 0),
    ("kr30ha", "target-frame"): put("dh.d.values.5", 1),
    ("kr30ha", "link-two-820"): put("results.geometry.cells.a3.0", "995"),
    ("kr30ha", "planar-model"): all_alike,
    ("kr30ha", "unfinished"): FINISHED,
    ("kr30ha", "lagrangian-label"): the_label_was_right,
    ("kr30ha", "loop-in-text"): instead(krl_program, "printed_program", lambda: LOOP),
    **{("kr30ha", name): nothing_added for name in planar_dynamics._NAMED},
    **{("kr30ha", name): SILENT for name in krl_program.PROGRAM if name != "loop-in-text"},
}


@pytest.mark.parametrize(("paper", "name"), [pytest.param(*key, id="-".join(key)) for key in BROKEN])
def test_a_broken_proof_does_not_hold(paper, name, monkeypatch):
    here = paper_study(paper)
    assert proved(paper, name).holds
    tables, results = copy.deepcopy(dict(here.data.tables)), copy.deepcopy(dict(here.data.results.raw))
    BROKEN[paper, name](tables, results, monkeypatch)
    evidence = PaperData(tables, results_of_tables(results, "results.toml"), here.data.file)
    assert not here.proofs[name](evidence).holds


@pytest.mark.parametrize(
    ("paper", "known"),
    [("kr30ha", matrices.PROOFS), ("lwr4plus", proofs.PROOFS), ("wam7", wam7_formulas.PROOFS)],
)
def test_the_proofs_of_a_paper_are_those_of_its_modules(paper, known):
    assert paper_study(paper).proofs == known
    assert set(formulas.POINTS) <= set(matrices.PROOFS)


def test_every_proof_is_broken_here_or_by_putting_its_cells_right():
    proven = {(paper, e.id): e for paper in studies() for e in paper_study(paper).data.errata if e.status == "proven"}
    assert {key for key, e in proven.items() if not e.patches} == set(BROKEN)
