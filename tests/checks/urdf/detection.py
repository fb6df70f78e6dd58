"""Which planted faults the linter finds: findings that the file has with the fault and not without, at the same place.

A finding counts at the planted link or at its joint. It is new where the file without the fault has none of the same
code and severity there; that one which was there says another number does not count.
"""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.checks.urdf.document import SEVERITIES, UrdfFinding, document_of
from lwr_dyn.checks.urdf.lint import lint_document
from tests.checks.urdf.fault_plants import FaultKind, FaultPlant, plants
from tests.checks.urdf.judged_arms import JudgedArm
from tests.checks.urdf.plant_site import sites

NOTHING = "missed"


@dataclass(frozen=True, slots=True)
class PlantVerdict:
    """What the linter made of one planted fault."""

    arm: str
    link: str
    kind: str
    size: float
    large: bool
    """Above its kind's floor, and not hopeless."""
    level: str
    """error | warning | note | missed: the gravest new finding."""
    codes: tuple[str, ...]
    elsewhere: int
    """New findings at other links and joints."""

    def seen(self, level: str) -> bool:
        """Whether a new finding is at least as grave as this."""
        return self.level != NOTHING and SEVERITIES.index(self.level) <= SEVERITIES.index(level)


@dataclass(frozen=True, slots=True)
class Alarm:
    """A finding at a moving link that was judged good, or at its joint."""

    arm: str
    link: str
    level: str
    code: str
    message: str


def findings_of(text: str, path: Path) -> tuple[UrdfFinding, ...]:
    """The linter's findings in a text, as if it stood in this file."""
    return lint_document(document_of(text, str(path))).findings


def judge_plant(arm: str, plant: FaultPlant, before: Iterable[UrdfFinding], path: Path) -> PlantVerdict:
    """The verdict on one plant; `before`: the findings of the file without it."""
    known = {_key(f) for f in before}
    new = [f for f in findings_of(plant.text, path) if _key(f) not in known]
    here = [f for f in new if f.subject in plant.subjects or f.link == plant.link]
    level = min((f.level for f in here), key=SEVERITIES.index, default=NOTHING)
    large = plant.is_large and not plant.kind.hopeless
    codes = tuple(sorted({f.code for f in here}))
    return PlantVerdict(arm, plant.link, plant.kind.name, plant.size, large, level, codes, len(new) - len(here))


def _key(finding: UrdfFinding) -> tuple[str, str, str]:
    return (finding.code, finding.level, finding.subject)


def verdicts(arm: JudgedArm, kinds: tuple[FaultKind, ...], share: float = 1.0, seed: int = 0) -> list[PlantVerdict]:
    """The verdicts on all plants in an arm, or on a share of them drawn by seed."""
    text, path = arm.text(), arm.path
    before = findings_of(text, path)
    chosen = plants(text, path, kinds, frozenset(arm.faults), lambda link, kind: _drawn(arm, link, kind, share, seed))
    return [judge_plant(arm.name, plant, before, path) for plant in chosen]


def _drawn(arm: JudgedArm, link: str, kind: str, share: float, seed: int) -> bool:
    """Whether the seed draws this plant; the same on every machine."""
    word = f"{seed} {arm.name} {link} {kind}".encode()
    return int.from_bytes(hashlib.sha256(word).digest()[:8], "big") < share * 2**64


def alarms(arm: JudgedArm) -> list[Alarm]:
    """Errors and warnings at the moving links of an arm without a true fault, and at their joints."""
    text, path = arm.text(), arm.path
    found: list[Alarm] = []
    findings = findings_of(text, path)
    for where in sites(text, path):
        if where.link in arm.faults:
            continue
        names = {f"link {where.link}", f"joint {where.joint}"}
        here = [f for f in findings if f.subject in names and f.level != "note"]
        found += [Alarm(arm.name, where.link, f.level, f.code, f.message) for f in here]
    return found
