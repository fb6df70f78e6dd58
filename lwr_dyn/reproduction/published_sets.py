"""Proofs of the errata of published sets: each computed from cells with its own erratum alone, or with none.

A set of masses, centres and tensors prints no results that could be recomputed, so a robot of such sets has no study:
what `lwr-dyn reproduce ROBOT` shows of it is its ledger. A proof takes what it needs from another set of the robot,
from a length, or from what a body can be.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import data_files, open_paper
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.files import make_folder, write_folder
from lwr_dyn.foundation.tables import Table, json_text
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import principal_moments
from lwr_dyn.reproduction.case import CONTRADICTION, LedgerEntry, LedgerRecord, Proof
from lwr_dyn.reproduction.compare import Verdicts
from lwr_dyn.reproduction.paper_page import counts, errata_words
from lwr_dyn.reproduction.paper_study import Reproduction

SAME = 1e-12
"""Share of the largest torque by which two arms of the same numbers may differ."""
RACK = 0.965
"""[m] of the boom of the Stanford arm, 38 in."""
ELBOW_UP = np.radians([0, 180, 180, 0, 0, 0])
"""Of joints 2 and 3, between the positions of the set `akb` and those of the Toolbox's table of the PUMA 560."""
LENGTHS = {"-0.0934, 0.4331": "-0.0934, 0.4318", "-0.07, 0.014]": "-0.07, 0.0141]"}
"""Lengths of the set `akb` -> those of the Toolbox's table, so that nothing but bodies differs."""


def arm_with(robot: str, *errata: str, of: str = "", change: Mapping[str, str] | None = None) -> Arm:
    """The arm of a set, or of the file's own tables, with exactly these errata, and with changed cells.

    Raises `ValueError`: a cell to be changed that the file does not have.
    """
    reading = f'\n[reading.only]\nabout = "for a proof"\nerrata = {list(errata)}\n' + (f'set = "{of}"' if of else "")
    text = data_files(robot)[f"{robot}.toml"]
    for old, new in (change or {}).items():
        if old not in text:
            raise ValueError(f"{robot}.toml has no {old}")
        text = text.replace(old, new)
    return arm_from_paper(parse_paper(text + reading, f"{robot}.toml", "only"))


def triangle(arm: Arm, link: int) -> float:
    """I3 / (I1 + I2) - 1 of a link (from 1): above 0 for no body."""
    moments = principal_moments((arm.chain.bodies or ())[link - 1].inertia_com)
    return float(moments[2] / (moments[0] + moments[1]) - 1.0)


def _states(n: int, count: int = 60) -> Array:
    return np.random.default_rng(0).uniform(-1.5, 1.5, (3, count, n))


def _torques(arm: Arm, states: Array) -> Array:
    return newton_euler_dynamics(arm.chain).inverse_dynamics(*states)


def fer_link4() -> Proof:
    """Principal moments of link 4 of the maker's set of the Panda, as printed."""
    found = {name: triangle(arm_with("panda", of=name), 4) for name in ("fer", "fr3", "fr3v2")}
    return Proof(
        "link 4 of fer has a moment that is larger than the other two together, as no body has; fr3 and fr3v2 have not",
        found["fer"] > 0.09 and max(found["fr3"], found["fr3v2"]) <= 0.0,
        {f"excess of the largest moment of {name}": x for name, x in found.items()},
        CONTRADICTION,
    )


def toolbox_link7() -> Proof:
    """Torques of the Toolbox's Panda against Gaz's, whose numbers it copies, with this erratum and without."""
    states = _states(7)
    gaz = _torques(arm_with("panda"), states)
    off = [
        float(np.abs(_torques(arm_with("panda", *ids, of="rtb_matlab"), states) - gaz).max())
        for ids in ((), ("link7-frame",))
    ]
    return Proof(
        "in the frame of the wrist the numbers of link 7 make the torques of Gaz's table, in that of the flange not",
        off[0] > 0.5 and off[1] <= SAME * float(np.abs(gaz).max()),
        {"largest difference of torque as coded [N m]": off[0], "with link 7 in the wrist's frame [N m]": off[1]},
    )


def toolbox_link1() -> Proof:
    """Cell by cell the centres of the Toolbox's Panda are Gaz's but one."""
    gaz, coded = (open_paper("panda", name).columns["inertial.com"].values for name in ("gaz", "rtb_matlab"))
    cells = [(i, k) for i in range(7) for k in range(3) if gaz[i][k] != coded[i][k]]
    read = arm_with("panda", "link1-centre", of="rtb_matlab").chain.bodies
    return Proof(
        "one of 21 cells of the centres is not Gaz's: z of link 1, where 0 stands",
        cells == [(0, 2)] and coded[0][2] == 0 and read is not None and read[0].com[2] == gaz[0][2],
        {"printed by Gaz [m]": gaz[0][2], "coded [m]": coded[0][2]},
    )


def puma_link4() -> Proof:
    """Gravity of the Toolbox's table against that of the set `akb` on the same lengths."""
    q = _states(6)[0]
    akb = newton_euler_dynamics(arm_with("puma560", of="akb", change=LENGTHS).chain).gravity_vector(q)
    off = [
        np.abs(newton_euler_dynamics(arm.chain).gravity_vector(q + ELBOW_UP) - akb).max(axis=0)
        for arm in (arm_with("puma560", *ids) for ids in ((), ("link4-centre-sign",)))
    ]
    return Proof(
        "with the sign turned gravity is that of the set akb in all joints; as coded it is off at joints 2 and 3",
        off[0][1:3].min() > 0.25 and off[1].max() <= SAME * float(np.abs(akb).max()),
        {"largest difference of gravity as coded [N m]": off[0].max(), "with the sign turned [N m]": off[1].max()},
    )


def stanford_centres() -> Proof:
    """Centres of the Stanford arm against the length of its boom, with this erratum and without."""
    far = [
        max(float(np.linalg.norm(body.com)) for body in (arm_with("stanford", *ids).chain.bodies or ()))
        for ids in ((), ("centres-tenfold",))
    ]
    return Proof(
        "as coded a centre lies many times the boom's length from its joint; with a tenth all lie within that length",
        far[0] > 6 * RACK and far[1] < RACK,
        {"farthest centre as coded [m]": far[0], "with a tenth [m]": far[1], "boom [m]": RACK},
    )


def stanford_moments() -> Proof:
    """The largest moment that the boom's mass can have about its own centre, against the printed one."""
    boom = (arm_with("stanford").chain.bodies or ())[2]
    printed, most = float(boom.inertia_com[0, 0]), boom.mass * (RACK / 2) ** 2
    return Proof(
        "no body of the boom's mass and length has the printed moment about its centre; about the joint it can",
        most < printed < boom.mass * RACK**2,
        {"printed [kg m^2]": printed, "largest about a centre [kg m^2]": most,
         "largest about an end [kg m^2]": boom.mass * RACK**2},
    )  # fmt: skip


def ur10e_tensors() -> Proof:
    """Cells of the tensors of the UR10e and the UR10."""
    ten, e = (open_paper(name).columns for name in ("ur10", "ur10e"))
    same = [a == b for a, b in zip(ten["inertial.inertia"].values, e["inertial.inertia"].values, strict=True)]
    masses = set(ten["inertial.mass"].values) & set(e["inertial.mass"].values)
    return Proof(
        "all six tensors are the UR10's, digit for digit, and no mass is",
        all(same) and not masses,
        {"tensors with the same digits": sum(same), "masses with the same digits": len(masses)},
        CONTRADICTION,
    )


def mamedov_edge() -> Proof:
    """How far the identified tensors of the UR10e are from the edge of what a body has."""
    arm = arm_with("ur10e", of="mamedov")
    edges = [abs(triangle(arm, link)) for link in range(1, 7)]
    return Proof(
        "in all six the largest moment is the sum of the other two, as in a disc or a rod without thickness",
        max(edges) < 1e-3,
        {"farthest from the edge, as a share": max(edges)},
        CONTRADICTION,
    )


PROOFS: Mapping[str, Mapping[str, Callable[[], Proof]]] = {
    "panda": {"fer-link4-triangle": fer_link4, "link7-frame": toolbox_link7, "link1-centre": toolbox_link1},
    "puma560": {"link4-centre-sign": puma_link4},
    "stanford": {"centres-tenfold": stanford_centres, "moments-about-origins": stanford_moments},
    "ur10e": {"tensors-of-ur10": ur10e_tensors, "mamedov-edge": mamedov_edge},
}
"""Robot -> id of a proven erratum -> its proof."""


def set_ledger(robot: str) -> tuple[LedgerEntry, ...]:
    """An entry for every erratum of a robot of published sets, each proof run now."""
    proofs = PROOFS.get(robot, {})
    return tuple(LedgerEntry(e, proofs[e.id]() if e.id in proofs else None) for e in open_paper(robot).errata)


def reproduced_sets(robot: str, place: Path) -> Reproduction:
    """The ledger of a robot of published sets, written as `results.json`; raises `FileAccessError`."""
    entries, nothing = set_ledger(robot), Verdicts(robot, ())
    holds, counted = all(entry.holds for entry in entries), counts(nothing, entries)
    words = " ".join(["Published sets: no printed results to recompute.", *errata_words(counted["errata"])])
    rows = [(e.erratum.id, e.erratum.set_name, e.erratum.status, _shown(e)) for e in entries]
    facts = [
        Fact("paper", robot, "Its name."), Fact("summary", words, "The outcome in words."),
        Fact("counts", counted, "How many errata are proven."), Fact("numbers", [], "None: sets print no results."),
        Fact("errata", [entry.record() for entry in entries],
             "Slips of the sets that are proven or read otherwise.", kind=list[LedgerRecord]),
        Fact("checks", {}, "None: `lwr-dyn check` runs them."), Fact("holds", holds, "Whether every proof holds."),
    ]  # fmt: skip
    table = Table("errata", ("id", "set", "status", "shown by"), rows)
    document = Document("", "", [Section("", [*facts, Note(words), table])], "lwr-dyn reproduce")
    write_folder(make_folder(place), {"results.json": json_text(document.record()) + "\n"})
    return Reproduction(holds, document)


def _shown(entry: LedgerEntry) -> str:
    """Statement and numbers of a proof, or why there is none."""
    proof = entry.proof
    if proof is None:
        return "not proven: " + entry.erratum.why
    numbers = ", ".join(f"{name} {x if isinstance(x, str) else format(x, '.4g')}" for name, x in proof.numbers.items())
    return f"{'' if proof.holds else 'DOES NOT HOLD: '}{proof.statement} ({numbers})"
