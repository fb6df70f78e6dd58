"""Largest B_ii of a reading by the global search of `control.worst_case_inertia`, beside the lattice's."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from lwr_dyn.checks.conventions.candidates import Candidate
from lwr_dyn.checks.conventions.evidence import DerivedNumber, Evidence
from lwr_dyn.checks.conventions.hypotheses import TableHypothesis
from lwr_dyn.checks.conventions.printed_table import PrintedTable
from lwr_dyn.checks.conventions.search import values
from lwr_dyn.control.inertia.worst_case import worst_case_inertia
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Rotor, with_bodies
from lwr_dyn.model.dh import Convention


@dataclass(frozen=True, slots=True)
class GlobalMaximum:
    """A published largest B_ii beside the one that the global search finds [kg m^2]."""

    number: DerivedNumber
    value: float

    @property
    def holds(self) -> bool:
        """The value has the printed digits."""
        return abs(self.value - self.number.printed.value) <= self.number.printed.half * (1.0 + 1e-6)


def global_maxima(table: PrintedTable, evidence: Evidence, candidate: Candidate) -> tuple[GlobalMaximum, ...]:
    """Every published largest B_ii under a reading, the base's first."""
    arm = arm_of(table, candidate.reading.table.convention, candidate.bodies)
    numbers = [x for x in evidence.numbers if x.quantity == "worst inertia"]
    return tuple(
        GlobalMaximum(x, worst_case_inertia(arm, x.joint).value) for x in sorted(numbers, key=lambda x: x.joint)
    )


def off_lattice(evidence: Evidence, hypothesis: TableHypothesis) -> tuple[tuple[str, float], ...]:
    """Numbers whose largest B_ii lies off the lattice of quarter turns in the plainest reading, by which share.

    The readings are sought on the lattice: for such numbers the search misses the truth, and they should be given
    with their poses instead.
    """
    table, options = hypothesis.table, hypothesis.options
    arm = arm_of(table, hypothesis.choice.convention, [o.body(0) for o in options])
    on_lattice = values(hypothesis.rows, options, [0] * table.n)
    out = []
    for lattice, number in zip(on_lattice, evidence.outermost_first, strict=True):
        if number.quantity == "worst inertia":
            exact = worst_case_inertia(arm, number.joint).value - float(arm.armature[number.joint])
            if exact - lattice > number.printed.half:
                out.append((number.name, float(exact / lattice - 1.0)))
    return tuple(out)


def arm_of(table: PrintedTable, convention: Convention, bodies: Sequence[Body]) -> Arm:
    """The arm of a table with these bodies, its joint box, and its rotors as armature."""
    chain = with_bodies(table.chain(convention), bodies)
    if table.armature is not None:
        rotors = [Rotor(1.0, float(x), reflected=True) for x in table.armature]
        chain = replace(chain, links=tuple(replace(link, rotor=r) for link, r in zip(chain.links, rotors, strict=True)))
    sides = [[None] * table.n if side is None else side.tolist() for side in (table.lower, table.upper)]
    limits = tuple(JointLimits(low, up) for low, up in zip(*sides, strict=True))
    return Arm(table.name, "resolved", table.name, chain, limits)
