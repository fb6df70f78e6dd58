"""A case: one paper's tables and printed results under one set of errata, from which formulas recompute numbers.

The errata ledger: every erratum of a data file with its proof, run anew, its effect and how certain it is.

An entry is "proven" when a computation shows the fault and its right reading; that computation is a function of the
paper's study. A ledger with a proven entry that has no proof, or whose proof fails, is wrong. "likely" has evidence
that no computation from printed numbers decides; "open" is listed without a verdict.

Formulas of numbers that any arm has; all studies share them. States (q, dq, ddq) stand in the block's `given`.
"""

import copy
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, TypedDict

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.reader import apply_errata, apply_patch, paper_of_tables
from lwr_dyn.arms.papers.schema import Erratum, Paper
from lwr_dyn.arms.papers.sets import tables_under
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_payload
from lwr_dyn.reproduction.papers import ResultBlock, Results, results_of_tables


@dataclass(frozen=True, slots=True)
class ComparedExpression:
    """A printed expression beside ours: ours as text, and whether both are the same for all values of the symbols."""

    text: str
    same: bool


Value = float | ComparedExpression | None
"""Of one cell, in its printed unit; None without a value."""


@dataclass(frozen=True, eq=False)
class PaperCase:
    """A paper's tables and results with exactly the errata `applied`; paper and arm are built when first used."""

    tables: Mapping[str, Any]
    results: Results
    file: str
    applied: frozenset[str]
    from_known_maxima: bool = False
    """Global searches only look where they ended for the package's own tables: for comparing hundreds of tables."""

    @cached_property
    def paper(self) -> Paper:
        """The data file as read; raises `PaperError` when it cannot be without some erratum."""
        return paper_of_tables(dict(self.tables), self.file, errata_read=())

    @cached_property
    def arm(self) -> Arm:
        """The arm; raises as `paper`."""
        return arm_from_paper(self.paper)

    @cached_property
    def geometry(self) -> Paper:
        """The data file without its masses and rotors; raises as `paper`."""
        return paper_of_tables(self.bare, self.file, errata_read=())

    @property
    def bare(self) -> dict[str, Any]:
        """The tables without masses and rotors."""
        return {name: table for name, table in self.tables.items() if name not in ("inertial", "rotors")}

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.tables["joints"]["kinds"])

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies of the links; none without masses in print."""
        return self.arm.chain.bodies or ()

    def values(self, table: str, column: str) -> list[Any]:
        """A column's values as printed, errata applied."""
        return list(self.tables[table][column]["values"])

    def block(self, name: str) -> ResultBlock:
        """A block of the results."""
        return self.results.blocks[name]

    @property
    def printed(self) -> dict[str, Mapping[str, Any]]:
        """Block -> its cells and the values printed beside them, by name."""
        return {name: block.printed for name, block in self.results.blocks.items()}

    def numbers(self, block: str, name: str) -> list[float]:
        """A printed column, or a list that is printed beside it, as numbers."""
        return [float(x) for x in self.results.blocks[block].printed[name]]


BASES = COMPUTED, STRUCTURAL, REPEATED = ("computed", "structural", "repeated in print")
"""What a recomputed number rests on, see `basis`."""

Recompute = Callable[[PaperCase, ResultBlock], Mapping[str, Any]]
"""Column -> a value per cell, nested as the cells are; the first line of its docstring is its formula in words."""


@dataclass(frozen=True, slots=True)
class PaperFormula:
    """A function that recomputes the numbers of a block."""

    function: Recompute
    slow: bool = False
    """Takes a simulation or symbolic algebra: left out where hundreds of tables are compared."""
    basis: str = ""
    """What its numbers rest on, where the experiment of `basis` cannot tell: simulations, algebra with letters, inputs
    outside the data file, counts and places that may be 1."""

    @property
    def formula(self) -> str:
        """The first line of its docstring: what it computes."""
        return (self.function.__doc__ or "").strip().splitlines()[0]


def formulas(*functions: Recompute, slow: bool = False, basis: str = "") -> dict[str, PaperFormula]:
    """Functions by their names, the `compute` of `results.toml`; `basis` as in `PaperFormula`."""
    return {function.__name__: PaperFormula(function, slow, basis) for function in functions}


@dataclass(frozen=True, eq=False)
class PaperData:
    """A paper's data file and printed results as they stand; cases of them are computed with chosen errata."""

    tables: Mapping[str, Any]
    """The data file as parsed."""
    results: Results
    file: str
    """Name of the data file, for messages."""

    @cached_property
    def paper(self) -> Paper:
        """The data file under the reading that the results name; raises `PaperError`, `UnknownNameError`."""
        return paper_of_tables(dict(self.tables), self.file, self.results.reading)

    @property
    def errata(self) -> tuple[Erratum, ...]:
        """Every erratum that the data file names; raises `PaperError`."""
        return self.paper.errata

    def case(self, *errata: str, from_known_maxima: bool = False) -> PaperCase:
        """The case with exactly these errata (ids); raises `PaperError` when a patch finds another printed value."""
        return self._case({*errata}, "", from_known_maxima)

    def _case(self, errata: Collection[str], set_name: str, from_known_maxima: bool = False) -> PaperCase:
        """The case of a published set, or of the file's own tables, with exactly these errata."""
        applied = [e for e in self.errata if e.id in errata]
        set_name = next((e.set_name for e in applied if e.set_name), set_name)
        tables = copy.deepcopy(tables_under(self.tables, self.paper.sets.get(set_name)))
        apply_errata(tables, tuple(applied), self.file)
        ids = frozenset(e.id for e in applied)
        return PaperCase(tables, patched_results(self.results, applied), self.file, ids, from_known_maxima)

    def reading(self, name: str = "", *more: str) -> PaperCase:
        """The case of a reading (that of the results if not named) and of further errata."""
        read = self.paper.readings[name] if name else self.paper.reading
        return self._case({*read.errata, *more}, read.set_name)


def patched_results(results: Results, applied: Collection[Erratum]) -> Results:
    """The printed results with errata applied; raises `PaperError` when a patch finds another printed value."""
    if not any(e.of_results() for e in applied):
        return results
    raw = copy.deepcopy(dict(results.raw))
    blocks = {name: block for name, block in raw.items() if isinstance(block, dict)}
    printed = {name: block.get("given", {}) | block["cells"] for name, block in blocks.items()}
    for erratum in applied:
        for patch in erratum.of_results():
            apply_patch({"results": printed}, patch, erratum.id, results.file)
    for name, block in blocks.items():
        for part in (block["cells"], block.get("given", {})):
            part |= {key: printed[name][key] for key in part}
    return results_of_tables(raw, results.file)


CORRECTION, CONTRADICTION = "correction", "contradiction"

KINDS = {
    CORRECTION: "what depends on it follows as read, and does not as printed",
    CONTRADICTION: "two printed statements exclude each other; which one is wrong is not shown",
}
"""Kind of a proof -> what it shows."""


@dataclass(frozen=True, slots=True, eq=False)
class Proof:
    """A computation that shows a fault of a paper: a statement, whether its numbers bear it out, those numbers.

    It shows its own erratum alone: it holds whether or not errata that are only likely are read.
    """

    statement: str
    holds: bool
    numbers: Mapping[str, float | str] = field(default_factory=dict)
    kind: str = CORRECTION
    """One of `KINDS`."""

    def __post_init__(self) -> None:
        plain = {name: x if isinstance(x, str) else float(x) for name, x in self.numbers.items()}
        object.__setattr__(self, "numbers", plain)
        object.__setattr__(self, "holds", bool(self.holds))

    @property
    def text(self) -> str:
        """Statement and numbers, a line each, and what a contradiction leaves open."""
        rows = [f"{name}: {x if isinstance(x, str) else format(x, '.6g')}" for name, x in self.numbers.items()]
        return "\n".join([self.statement, *rows, *([KINDS[self.kind]] if self.kind == CONTRADICTION else [])])

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "statement": self.statement, "numbers": dict(self.numbers), "holds": self.holds, "kind": self.kind
        }  # fmt: skip


Prove = Callable[[PaperData], Proof]
"""A proof of an erratum, computed from the paper's data."""


class ProofRecord(TypedDict):
    """`Proof.record`."""

    statement: str
    numbers: Annotated[dict[str, float | str], "The numbers that bear it out."]
    holds: bool
    kind: Annotated[str, "correction: what is read is shown; contradiction: that one of two statements is wrong."]


class LedgerRecord(TypedDict):
    """`LedgerEntry.record`."""

    id: str
    where: Annotated[str, "Place in the paper."]
    printed: str
    read_as: str
    why: str
    effect: str
    severity: str
    status: Annotated[str, "proven, likely or open."]
    proof: Annotated[ProofRecord | None, "Computed now; null where it is not proven."]


@dataclass(frozen=True, slots=True, eq=False)
class LedgerEntry:
    """One erratum of a paper with its proof; None where it is not proven."""

    erratum: Erratum
    proof: Proof | None

    @property
    def holds(self) -> bool:
        """A proven entry has a proof that holds; the others claim nothing."""
        return self.erratum.status != "proven" or (self.proof is not None and self.proof.holds)

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        keys = ("id", "where", "printed", "read_as", "why", "effect", "severity", "status")
        proof = None if self.proof is None else self.proof.record()
        return {key: getattr(self.erratum, key) for key in keys} | {"proof": proof}


def ledger(data: PaperData, proofs: Mapping[str, Prove]) -> tuple[LedgerEntry, ...]:
    """An entry for every erratum of a paper, each proof run now."""
    return tuple(LedgerEntry(e, proofs[e.id](data) if e.id in proofs else None) for e in data.errata)


AXIS = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
"""For n . I n every entry of the tensor I counts, each with another weight."""


def _state(case: PaperCase, block: ResultBlock, name: str) -> Array:
    return np.array(block.printed.get(name, np.zeros(case.n)), dtype=np.float64)


def total_mass(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """sum m_i over the moving links [kg]"""
    return {"mass": [sum(case.values("inertial", "mass"))]}


def torques(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """g(q), B(q) ddq, C(q, dq) dq by the hand-written recursion [N m]"""
    recursion = Recursion.of(case.arm.require_dynamics())
    q, dq, ddq = (_state(case, block, name) for name in ("q", "dq", "ddq"))
    g = recursion.gravity_vector(q)
    inertial = recursion.mass_matrix(q) @ ddq
    return {"g": g, "B_ddq": inertial, "C_dq": recursion.inverse_dynamics(q, dq, ddq) - inertial - g}


def payload_torque(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """g(q) with the rated payload at the flange [N m]"""
    chain = with_payload(case.arm.require_dynamics(), case.arm.ratings.payload or 0.0)
    return {"g": Recursion.of(chain).gravity_vector(_state(case, block, "q"))}


def link_moments(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """n . I_i n about each link's centre of mass, n = (1, 2, 3)/sqrt(14) in the DH frame [kg m^2]"""
    return {"moment": [AXIS @ body.inertia_com @ AXIS for body in case.bodies]}


def flange(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """T_0n(q): position [m] and the flange's axes in the base"""
    T = flange_pose(case.arm.chain, _state(case, block, "q"))
    return {"position": T[:3, 3], "rotation": T[:3, :3].tolist()}


def limits(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Limits in SI, positions in the DH coordinate: [rad], [rad/s], [N m]"""
    arm = case.arm
    columns = {"lower": arm.lower, "upper": arm.upper, "velocity": arm.velocity, "effort": arm.effort}
    return {name: columns[name] for name in dict.fromkeys(c.column for c in block.cells)}


def height(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Height of the flange above the floor at q: pedestal plus p_z [m]"""
    T = flange_pose(case.arm.chain, _state(case, block, "q"))
    return {"height": [case.arm.drawing.pedestal + T[2, 3]]}


def armature(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """k_r^2 I_m: rotor inertia seen at the joint [kg m^2]"""
    return {"armature": case.arm.armature}


SHARED = formulas(total_mass, torques, payload_torque, link_moments, flange, limits, height, armature)
