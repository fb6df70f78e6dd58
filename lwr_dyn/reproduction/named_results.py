"""What a result of a user's own paper may be: a quantity of the arm by name, or an expression of such and of columns.

    mass_matrix[1,2]                          an entry of B(q), counted from 1
    gravity                                   all of g(q)
    gravity[2] / limits.effort[2]             an expression; names stand for SI values
    inertial.mass[1] * base.gravity[3]        cells of the file's own tables

Expressions are numbers, names, + - * / ^ and the functions of `checks.tables.arithmetic`; no code is run.
"""

import ast
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import PER_JOINT, TABLES, Paper
from lwr_dyn.checks.tables import arithmetic
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.regressor import chain_with_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, did_you_mean
from lwr_dyn.kinematics.forward import flange_pose, jacobian
from lwr_dyn.model.arm import Arm
from lwr_dyn.simulation.metrics import MILLI, Metrics

State = Mapping[str, Any]
"""q, dq, ddq (n,) of a result, those that it gives [rad, m, s]; `run`, the `Metrics` of its closed loop."""
Powers = Array
"""Of metre, kilogram and second, (..., 3) for a quantity of shape (...)."""
JOINTS = PER_JOINT
"""In the shape of a quantity: one entry a joint."""


@dataclass(frozen=True, slots=True)
class NamedQuantity:
    """A quantity of an arm: what it is, which of q, dq, ddq and run it takes, its shape, its value and its unit."""

    about: str
    takes: tuple[str, ...]
    shape: tuple[int, ...]
    value: Callable[[Arm, State], Any]
    powers: Callable[[Array], Powers]
    """Of (n,) powers of the joints' coordinates: 0 for an angle, 1 for a length."""


def _recursion(arm: Arm) -> Recursion:
    return Recursion.of(chain_with_dynamics(arm))


def _inverse_dynamics(arm: Arm, state: State) -> Array:
    torque: Array = _recursion(arm).inverse_dynamics(state["q"], state["dq"], state["ddq"])
    return torque


def _force(s: Array) -> Powers:
    """Of a torque or a force: energy over the coordinate."""
    return np.stack([2.0 - s, np.ones_like(s), np.full_like(s, -2.0)], axis=-1)


def _inertia(s: Array) -> Powers:
    return np.stack([2.0 - 2.0 * s, np.ones_like(s), np.zeros_like(s)], axis=-1)


def _inertias(s: Array, per_second: float = 0.0) -> Powers:
    length = 2.0 - s[:, None] - s
    return np.stack([length, np.ones_like(length), np.full_like(length, -per_second)], axis=-1)


def _jacobian_powers(s: Array) -> Powers:
    length = np.vstack([np.tile(1.0 - s, (3, 1)), np.tile(-s, (3, 1))])
    return np.stack([length, np.zeros_like(length), np.zeros_like(length)], axis=-1)


def _of_run(
    about: str, per_joint: bool, value: Callable[[Metrics], Any], powers: Callable[[Array], Powers]
) -> NamedQuantity:
    shape = (JOINTS,) if per_joint else ()
    return NamedQuantity(f"run: {about}", ("run",), shape, lambda _, x: value(x["run"]), powers)


def _position(s: Array) -> Powers:
    return np.stack([s, np.zeros_like(s), np.zeros_like(s)], axis=-1)


METRE, SECOND = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])

METRICS: dict[str, NamedQuantity] = {
    "tip_rms": _of_run("error of the tip, RMS", False, lambda m: m.tip_rms_mm / MILLI, lambda _: METRE),
    "tip_max": _of_run("error of the tip, largest", False, lambda m: m.tip_max_mm / MILLI, lambda _: METRE),
    "position_rms": _of_run("error of a joint, RMS", True, lambda m: m.position_mrad.rms / MILLI, _position),
    "position_mean": _of_run(
        "error of a joint, mean of its size", True, lambda m: m.position_mrad.mean_abs / MILLI, _position
    ),
    "position_max": _of_run(
        "error of a joint, largest", True,
        lambda m: np.maximum(m.position_mrad.max, -m.position_mrad.min) / MILLI, _position,
    ),
    "peak_torque": _of_run("largest torque that acts", True, lambda m: m.peak_torque, _force),
    "peak_command": _of_run("largest torque that the law asks for", True, lambda m: m.peak_command, _force),
    "peak_speed": _of_run("largest speed", True, lambda m: m.peak_speed, lambda s: _position(s) - SECOND),
    "saturated_s": _of_run(
        "time beyond the torque limit", True, lambda m: m.saturated_s, lambda s: np.tile(SECOND, (len(s), 1))
    ),
    "limit_margin": _of_run("least distance from a position limit", True, lambda m: m.limit_margin, _position),
}  # fmt: skip
"""Name -> figure of a closed loop, by the names of a study of many (`lwr-dyn sweep`)."""

QUANTITIES: dict[str, NamedQuantity] = {
    "mass_matrix": NamedQuantity(
        "B(q)", ("q",), (JOINTS, JOINTS), lambda arm, x: _recursion(arm).mass_matrix(x["q"]), _inertias
    ),
    "gravity": NamedQuantity(
        "g(q), the torque that holds the arm", ("q",), (JOINTS,),
        lambda arm, x: _recursion(arm).gravity_vector(x["q"]), _force,
    ),
    "coriolis_matrix": NamedQuantity(
        "C(q, dq), the Christoffel form", ("q", "dq"), (JOINTS, JOINTS),
        lambda arm, x: _recursion(arm).coriolis_matrix(x["q"], x["dq"]), lambda s: _inertias(s, 1.0),
    ),
    "bias_torque": NamedQuantity(
        "C(q, dq) dq + g(q)", ("q", "dq"), (JOINTS,),
        lambda arm, x: _recursion(arm).bias_torque(x["q"], x["dq"]), _force,
    ),
    "inverse_dynamics": NamedQuantity(
        "tau = B ddq + C dq + g", ("q", "dq", "ddq"), (JOINTS,), _inverse_dynamics, _force
    ),
    "eigenvalue": NamedQuantity(
        "eigenvalues of B(q), the smallest first", ("q",), (JOINTS,),
        lambda arm, x: np.linalg.eigvalsh(_recursion(arm).mass_matrix(x["q"])), _inertia,
    ),
    "largest_inertia": NamedQuantity(
        "largest B_ii over the position limits", (), (JOINTS,),
        lambda arm, _: np.array([m.value for m in worst_case_inertias(arm)]), _inertia,
    ),
    "pose": NamedQuantity(
        "x, y, z of the flange in the base", ("q",), (3,),
        lambda arm, x: flange_pose(arm.chain, x["q"])[:3, 3], lambda _: np.tile([1.0, 0.0, 0.0], (3, 1)),
    ),
    "rotation": NamedQuantity(
        "axes of the flange in the base, the columns of R(q)", ("q",), (3, 3),
        lambda arm, x: flange_pose(arm.chain, x["q"])[:3, :3], lambda _: np.zeros((3, 3, 3)),
    ),
    "jacobian": NamedQuantity(
        "J(q) of the flange, velocity above angular velocity", ("q",), (6, JOINTS),
        lambda arm, x: jacobian(arm.chain, x["q"]), _jacobian_powers,
    ),
    "armature": NamedQuantity(
        "k_r^2 I_m, rotor inertia seen at the joint", (), (JOINTS,), lambda arm, _: arm.armature, _inertia
    ),
    "total_mass": NamedQuantity(
        "sum of the masses of the moving links", (), (),
        lambda arm, _: sum(b.mass for b in arm.require_dynamics().bodies or ()), lambda _: np.array([0.0, 1.0, 0.0]),
    ),
    **METRICS,
}  # fmt: skip
"""Name -> quantity, as `compute` of a `[[result]]` takes it."""

CONSTANTS = {"pi": math.pi}
FORM = "a quantity such as gravity[2], or numbers, names, + - * / ^ and functions such as sqrt, sin, hypot"
_NAME = re.compile(r"([A-Za-z_][\w.]*)(?:\[([\d,]+)\])?")


@dataclass(frozen=True, slots=True)
class Term:
    """A name of an expression with its indices, counted from 1: "mass_matrix[1,2]", "inertial.mass[3]", "pi"."""

    text: str
    name: str
    index: tuple[int, ...]

    @property
    def takes(self) -> tuple[str, ...]:
        """Which of q, dq, ddq, run it needs."""
        return QUANTITIES[self.name].takes if self.name in QUANTITIES else ()

    def shape(self, n: int) -> tuple[int, ...]:
        """Of its values for an arm of n joints; () where the indices name one number."""
        whole = _shape(self.name, n)
        return whole if not self.index else ()

    def value(self, paper: Paper, arm: Callable[[], Arm], state: State) -> Array:
        """Its number or numbers in SI; raises `MissingDataError` where the file lacks what a quantity needs."""
        if self.name in CONSTANTS:
            return np.array(CONSTANTS[self.name])
        if self.name in QUANTITIES:
            whole = np.asarray(QUANTITIES[self.name].value(arm(), state), dtype=np.float64)
        else:
            whole = _column(paper, self.name)
        return np.asarray(whole[tuple(i - 1 for i in self.index)])

    def powers(self, turning: Array) -> Powers | None:
        """Of metre, kilogram, second of its values; None for a column, whose unit stands in the file."""
        if self.name not in QUANTITIES:
            return None
        whole = QUANTITIES[self.name].powers(1.0 - turning)
        return np.asarray(whole[tuple(i - 1 for i in self.index)])


def _shape(name: str, n: int) -> tuple[int, ...]:
    if name in CONSTANTS:
        return ()
    if name in QUANTITIES:
        shape = QUANTITIES[name].shape
    else:
        table, _, column = name.partition(".")
        rule = TABLES[table][column]
        shape = (JOINTS, *rule.row) if rule.per_joint else rule.row
    return tuple(n if size == JOINTS else size for size in shape)


def _column(paper: Paper, name: str) -> Array:
    table, _, column = name.partition(".")
    values = paper.columns[name].si()
    return values if TABLES[table][column].per_joint else values[0]


@dataclass(frozen=True, slots=True)
class ResultFormula:
    """What a result is: one term, or an expression of terms that are one number each."""

    text: str
    tree: ast.expr
    terms: tuple[Term, ...]

    @property
    def term(self) -> Term | None:
        """The only term; None for an expression."""
        return self.terms[0] if arithmetic.name_of(self.tree) is not None else None

    @property
    def takes(self) -> tuple[str, ...]:
        """Which of q, dq, ddq, run it needs, in this order."""
        needed = {name for term in self.terms for name in term.takes}
        return tuple(name for name in ("q", "dq", "ddq", "run") if name in needed)

    def shape(self, n: int) -> tuple[int, ...]:
        """Of its value for an arm of n joints."""
        return self.term.shape(n) if self.term else ()

    def value(self, paper: Paper, arm: Callable[[], Arm], state: State) -> Array:
        """In SI; `arm` is asked for where a quantity needs it.

        Raises `OptionError` for a number that the file does not know, and for an expression without a value;
        `MissingDataError` where the file lacks what a quantity needs.
        """
        found = {term.text: term.value(paper, arm, state) for term in self.terms}
        for name, x in found.items():
            if not np.isfinite(x).all():
                raise OptionError("compute", f"{name} is unknown", "what the file gives")
        if self.term:
            return found[self.term.text]
        value = arithmetic.value_of(self.tree, {name: float(x) for name, x in found.items()})
        if math.isnan(value):
            given = ", ".join(f"{name} = {float(x):.6g}" for name, x in found.items() if name not in CONSTANTS)
            fault = f"{self.text!r} has no value{f' for {given}' if given else ''}"
            raise OptionError("compute", fault, "no division by 0, no root of a number below 0, powers up to 20")
        return np.array(value)


def formula_of(text: str, paper: Paper) -> ResultFormula:
    """The formula of a text, checked against the file's joints and columns.

    Raises
    ------
    OptionError
        No expression, an unknown name, an index beyond the joints, or an expression of what is not one number.
    """
    text = text.strip()
    tree = arithmetic.parsed(text, indexed=True)
    if tree is None:
        raise OptionError("compute", repr(text), f"{FORM}, at most {arithmetic.LONGEST} characters")
    terms = tuple(_terms(tree, paper))
    formula = ResultFormula(text, tree, terms)
    for term in terms if formula.term is None else ():
        if shape := term.shape(paper.n):
            one = ",".join("1" for _ in shape)
            raise OptionError("compute", f"{term.text}, {math.prod(shape)} numbers", f"one of them: {term.name}[{one}]")
    return formula


def _terms(tree: ast.expr, paper: Paper) -> Iterator[Term]:
    for text in dict.fromkeys(arithmetic.names_in(tree)):
        match = _NAME.fullmatch(text)
        name = match[1] if match else text
        if match is None or not _known(name, paper):
            known = (*QUANTITIES, *paper.columns, *CONSTANTS)
            raise OptionError("compute", f"no quantity or column {name!r}{did_you_mean(name, known)}", ", ".join(known))
        index, shape = tuple(map(int, match[2].split(","))) if match[2] else (), _shape(name, paper.n)
        if index and (len(index) != len(shape) or any(not 1 <= i <= k for i, k in zip(index, shape, strict=True))):
            ranges = ",".join(f"1 to {k}" for k in shape)
            raise OptionError("compute", text, f"{name}[{ranges}], counted from 1" if shape else f"{name}, one number")
        yield Term(text, name, index)


def _known(name: str, paper: Paper) -> bool:
    return name in QUANTITIES or name in CONSTANTS or name in paper.columns
