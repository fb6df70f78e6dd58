"""A user's own paper: the printed results in its data file, `[[result]]`, recomputed and judged without any Python.

    [[result]]
    id = "b22"
    where = "Table IV, b22"                 # where it is printed
    printed = "0.1205"                      # text, so that its digits count; a list for all numbers of a quantity
    unit = "kg m^2"
    compute = "mass_matrix[2,2]"            # what it is, see `named_results`
    q_deg = [0, 90, 0]                      # or q; with dq, ddq or run (`own_runs`) where it takes them

Further fields: `range` for a number that is read off a figure, `assumed` for conditions that the paper does not print,
`errata` for those that may explain a difference beside those of the file's reading (see `FEW`), `note`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.reader import paper_of_tables
from lwr_dyn.arms.papers.schema import RESULT, RUN, Paper
from lwr_dyn.checks.tables import arithmetic
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError, OptionError, PaperError
from lwr_dyn.foundation.fields import LARGEST, Fields, parse_toml
from lwr_dyn.foundation.files import read_text
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.printed_number import printed_number
from lwr_dyn.reproduction.case import COMPUTED, PaperCase, PaperData, PaperFormula, Proof, Prove
from lwr_dyn.reproduction.compare import AFTER, compare_numbers
from lwr_dyn.reproduction.named_results import ResultFormula, formula_of
from lwr_dyn.reproduction.own_runs import NAME, NAMES, OwnRuns, read_runs
from lwr_dyn.reproduction.paper_study import OwnFile, PaperStudy, Pictures, Progress, Reproduction, study_document
from lwr_dyn.reproduction.papers import SCHEMA, ResultBlock, Study, results_of_tables

STATE = ("q", "dq", "ddq")
FEW = 8
"""So many errata are all tried for each result; of more, and for a run, those of the reading and those it names."""
COLUMN = "printed"
"""The column of every result: an erratum names the number `results.ID.printed[0]`."""
NEEDED = "a .toml with [[result]], as `lwr-dyn new paper` writes it"


@dataclass(frozen=True, slots=True)
class OwnResult:
    """One `[[result]]`: its block in the form of a `results.toml`, and its formula."""

    id: str
    block: Mapping[str, Any]
    formula: ResultFormula


def own_study(path: str | Path) -> PaperStudy:
    """The study of a user's own data file, from its tables and its `[[result]]` alone.

    Raises
    ------
    FileAccessError
        A file that cannot be read.
    PaperError
        A breach of the schema, or a result that cannot be computed: which file, which field.
    """
    file = Path(path).name
    tables = parse_toml(read_text(path, NEEDED), file)
    paper = paper_of_tables(tables, file)
    top = Fields(tables, file)
    entries = top.tables(RESULT, default=[])
    if not entries:
        raise top.refuse(RESULT, "missing", f"tables [[{RESULT}]], as `lwr-dyn new paper` writes them")
    runs = read_runs(tables, paper, Path(path).parent)
    found = [_result(fields, paper, runs) for fields in entries]
    raw: dict[str, Any] = {"schema": SCHEMA, "paper": paper.name}
    for entry, fields in zip(found, entries, strict=True):
        if entry.id in raw:
            raise fields.refuse("id", f"{entry.id!r} twice", "each id once")
        raw[entry.id] = entry.block
    data = PaperData(tables, results_of_tables(raw, file), file)
    formulas = {entry.block["compute"]: _paper_formula(entry, runs) for entry in found}
    _check_values(data, found, entries, runs)
    failing = tuple(name for name in paper.reading_names[1:] if paper.left_in_place(name))
    study = Study(0, "", "", failing_readings=failing)

    def run(_: Path, __: Arm, progress: Progress) -> Reproduction:
        """The runs, for their files and audits; a study in Python is for what results cannot say."""
        progress("runs")
        simulated = tuple((name, f"{name}.npz", runs.run(name, data.reading())) for name in runs.rows)
        return Reproduction(True, study_document(), pictures=Pictures(simulated=simulated))

    own = PaperStudy(paper.name, study, data, formulas, {}, OwnFile(str(path), run))
    return replace(own, proofs=_proofs(own))


def _result(fields: Fields, paper: Paper, runs: OwnRuns) -> OwnResult:
    name = fields.text("id")
    if not NAME.fullmatch(name) or name in ("schema", "paper", "reading"):
        raise fields.refuse("id", repr(name), NAMES)
    fields.path = f"{RESULT}.{name}"  # from here on messages name it
    where, unit = fields.text("where"), fields.text("unit")
    texts = fields.take("printed", object)
    formula = _formula(fields, paper)
    given = _state(fields, formula, paper)
    _check_run(fields, formula, runs, given)
    cells = _printed(fields, "printed", texts, formula.shape(paper.n), formula.text)
    _check_unit(fields, unit, formula, paper)
    known = [e.id for e in paper.errata]
    few = len(known) <= FEW and "run" not in formula.takes
    errata = fields.take("errata", list, default=known if few else [])
    for unknown in (x for x in errata if x not in known):
        raise fields.refuse("errata", repr(unknown), f"one of {', '.join(known) or 'none'}")
    block = {
        "where": where, "form": "table", "unit": unit, "compute": _words(formula, given), "cells": {COLUMN: cells},
        "given": given, "errata": errata, "note": fields.text("note", default=""),
        "needs": list(fields.texts("assumed", default=())), "range_of": [COLUMN],
    }  # fmt: skip
    if not isinstance(cells[0], list):
        block["rows"] = [name] if isinstance(texts, str) else [f"{name}[{i + 1}]" for i in range(len(cells))]
    spans = fields.take("range", list, default=None)
    if spans is not None:
        block |= {"form": "figure", "ranges": {COLUMN: [spans] if isinstance(texts, str) else spans}}
    fields.refuse_unknown()
    try:
        results_of_tables({"schema": SCHEMA, "paper": paper.name, name: block}, paper.file)
    except PaperError as fault:
        at = fault.field.removeprefix(f"{name}.").replace(f"ranges.{COLUMN}", "range")
        raise fields.refuse(at, str(fault.found), fault.allowed) from None
    return OwnResult(name, block, formula)


def _words(formula: ResultFormula, given: Mapping[str, Any]) -> str:
    """The formula with the state that it is taken at: "gravity[2] at q = (0, 90) deg", "tip_rms at run move"."""
    states = []
    for key, row in given.items():
        name, degrees = key.removesuffix("_deg"), " deg" if key.endswith("_deg") else ""
        states.append(f"run {row}" if key == "run" else f"{name} = ({', '.join(f'{x:g}' for x in row)}){degrees}")
    return f"{formula.text} at {', '.join(states)}" if states else formula.text


def _formula(fields: Fields, paper: Paper) -> ResultFormula:
    try:
        return formula_of(fields.text("compute"), paper)
    except OptionError as fault:
        raise fields.refuse(fault.name, str(fault.found), fault.allowed) from None


def _state(fields: Fields, formula: ResultFormula, paper: Paper) -> dict[str, Any]:
    """The given q, dq, ddq as the file has them: q in degrees under `q_deg`."""
    given: dict[str, Any] = {}
    for name in STATE:
        keys = (name, f"{name}_deg") if name == "q" else (name,)
        values = {key: fields.row(key, paper.n, _row_words(key, paper)) for key in keys if key in fields.unread()}
        if len(values) > 1:
            raise fields.refuse("q", "given with q_deg", "one of them")
        if name in formula.takes and not values:
            raise fields.refuse(keys[-1], "missing", f"{_row_words(keys[-1], paper)}: {formula.text} needs it")
        if name not in formula.takes and values:
            raise fields.refuse(next(iter(values)), "given", f"left out: {formula.text} does not take it")
        given |= {key: list(row) for key, row in values.items()}
    return given


def _check_run(fields: Fields, formula: ResultFormula, runs: OwnRuns, given: dict[str, Any]) -> None:
    """Add the name of the run, where the formula takes one; raise `PaperError` for none of that name."""
    if "run" not in formula.takes:
        if "run" in fields.unread():
            raise fields.refuse("run", "given", f"left out: {formula.text} does not take it")
        return
    names = tuple(runs.rows)
    if not names:
        raise fields.refuse("compute", formula.text, f"with a table [{RUN}.NAME], of which the file has none")
    given["run"] = fields.choice("run", names)


def _row_words(key: str, paper: Paper) -> str:
    units = {"q_deg": ("deg", "m"), "q": ("rad", "m"), "dq": ("rad/s", "m/s"), "ddq": ("rad/s^2", "m/s^2")}[key]
    sliding = JointKind.PRISMATIC in paper.kinds
    return f"a list of {paper.n} finite numbers, one a joint [{units[0]}{f', sliding {units[1]}' if sliding else ''}]"


def _printed(fields: Fields, place: str, texts: Any, shape: tuple[int, ...], what: str) -> list[Any]:
    """The texts as a column of a block: a number is a list of one, vectors and matrices are lists."""
    if not shape:
        return [_number(fields, place, texts)]
    if not isinstance(texts, list) or len(texts) != shape[0]:
        found = f"{len(texts)} entries" if isinstance(texts, list) else repr(texts)
        one = ",".join("1" for _ in shape)
        raise fields.refuse(place, found, f"a list of {shape[0]} for {what}; one number is {what}[{one}]")
    if len(shape) == 1:
        return [_number(fields, f"{place}[{i}]", text) for i, text in enumerate(texts)]
    return [_printed(fields, f"{place}[{i}]", row, shape[1:], f"a row of {what}") for i, row in enumerate(texts)]


def _number(fields: Fields, place: str, text: Any) -> str:
    number = printed_number(text) if isinstance(text, str) else None
    if number is None:
        found = f"{text!r}, a number without its digits" if isinstance(text, int | float) else repr(text)
        raise fields.refuse(place, found, 'a number as printed, in quotation marks: "2.924"')
    if abs(number.value) > LARGEST or number.half < 1.0 / LARGEST:
        raise fields.refuse(place, repr(text), f"a number up to {LARGEST:g}, its last digit down to {1 / LARGEST:g}")
    return number.text


def _check_unit(fields: Fields, name: str, formula: ResultFormula, paper: Paper) -> None:
    """Raise `PaperError` for an unknown unit, or one that a named quantity does not have."""
    unit = arithmetic.unit_of(name)
    if unit is None:
        raise fields.refuse("unit", repr(name), 'units such as kg m^2, N m, mm, deg, "1" for a bare number')
    turning = np.array([kind is JointKind.REVOLUTE for kind in paper.kinds], dtype=np.float64)
    powers = formula.term.powers(turning) if formula.term else None
    if powers is None:
        return
    different = {tuple(row): None for row in powers.reshape(-1, 3).tolist()}
    if len(different) > 1:
        raise fields.refuse("unit", repr(name), f"{formula.text} entry by entry: turning and sliding joints differ")
    (wanted,) = different
    if unit.powers[:3] != wanted:
        metre, kilogram, second = wanted
        has = arithmetic.in_words((metre, kilogram, second, 0.0))
        raise fields.refuse("unit", repr(name), f"a unit of {has}, which {formula.text} has")


def _paper_formula(entry: OwnResult, runs: OwnRuns) -> PaperFormula:
    """The formula as the function of a block; its first line is its text."""

    def recompute(case: PaperCase, block: ResultBlock) -> Mapping[str, Any]:
        return {COLUMN: _value(entry.formula, case, block, runs)}

    recompute.__doc__ = entry.block["compute"]
    simulated = "run" in entry.formula.takes
    return PaperFormula(recompute, simulated, COMPUTED if simulated else "")


def _value(formula: ResultFormula, case: PaperCase, block: ResultBlock, runs: OwnRuns) -> Any:
    """In the printed unit, nested as the cells are."""
    unit = arithmetic.unit_of(block.cells[0].unit)
    state: dict[str, Any] = _si_state(case, block)
    if "run" in block.printed:
        state["run"] = runs.metrics(block.printed["run"], case)
    value = formula.value(case.paper, lambda: case.arm, state) / (unit.factor if unit else 1.0)
    return value.tolist() if formula.shape(case.n) else [float(value)]


def _si_state(case: PaperCase, block: ResultBlock) -> dict[str, Array]:
    state = {name: np.array(block.printed[name], dtype=np.float64) for name in STATE if name in block.printed}
    if "q_deg" in block.printed:
        q = np.array(block.printed["q_deg"], dtype=np.float64)
        state["q"] = np.where(case.arm.chain.turning, np.radians(q), q)
    return state


def _check_values(data: PaperData, found: Sequence[OwnResult], entries: Sequence[Fields], runs: OwnRuns) -> None:
    """Raise `PaperError` for the first result that the tables give no value for, under the file's own reading."""
    case = data.reading()
    for entry, fields in zip(found, entries, strict=True):
        try:
            _value(entry.formula, case, case.block(entry.id), runs)
        except OptionError as fault:
            raise fields.refuse("compute", str(fault.found), fault.allowed) from None
        except (LwrDynError, ArithmeticError, ValueError) as fault:
            allowed = "a result that the tables of the file give"
            raise fields.refuse("compute", f"{entry.formula.text} has no value: {fault}", allowed) from None


def _proofs(study: PaperStudy) -> dict[str, Prove]:
    """For each erratum that the file calls proven: printed results follow with it, and do not without."""
    return {e.id: _proof_of(e.id, study) for e in study.data.errata if e.status == "proven"}


def _proof_of(erratum: str, study: PaperStudy) -> Prove:
    def prove(data: PaperData) -> Proof:
        fitted = {at for e in data.errata if e.id == erratum for patch in e.patches for at in patch.fitted_to}
        numbers = [n for n in compare_numbers(study, slow=True).numbers if n.cell.path not in fitted]
        shown = {n.cell.path.removeprefix("results."): n for n in numbers if n.verdict == AFTER and erratum in n.errata}
        if not shown:
            return Proof("no printed result of the file shows it: add one that does, or call it likely", False)
        said = {name: f"printed {n.cell.printed}, with the erratum {n.value:.8g}" for name, n in shown.items()}
        return Proof("these printed results follow with the erratum, and do not without it", True, said)

    return prove
