"""Findings grouped by cause: one line for what one slip did to many links, the largest first."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.audit.urdf.finding import SEVERITIES, FindingSeverity, UrdfFinding
from lwr_dyn.audit.urdf.rules import READING, RULES

FOLLOWING = {
    "masses look like g": ("density", "effort-weight", "inertia-spread", "inertia-bound", "inertia-slip"),
    "origins look like millimetres": ("bodies-apart", "joint-off-bodies", "effort-weight"),
    "centres of mass look like millimetres": ("centre-outside", "effort-weight"),
    "angles look like degrees": ("bodies-apart", "joint-off-bodies", "effort-weight"),
}
"""Causes, and rules whose findings follow from them: they stand in the group of the cause."""


@dataclass(frozen=True, slots=True)
class FindingGroup:
    """Findings of one cause."""

    cause: str
    findings: tuple[UrdfFinding, ...]
    following: tuple[UrdfFinding, ...] = ()
    """Findings that most likely follow from these."""

    @property
    def severity(self) -> FindingSeverity:
        """The worst severity."""
        return min((f.level for f in self.findings), key=SEVERITIES.index)

    @property
    def codes(self) -> tuple[str, ...]:
        """The codes of its own findings."""
        return tuple(dict.fromkeys(f.code for f in self.findings))


def grouped(findings: Sequence[UrdfFinding]) -> tuple[FindingGroup, ...]:
    """The groups: errors first, then warnings, then notes; of these the largest first."""
    by_cause: dict[str, list[UrdfFinding]] = defaultdict(list)
    for finding in findings:
        by_cause[finding.cause or _about(finding.code)].append(finding)
    follows = {code: cause for cause in reversed(list(FOLLOWING)) if cause in by_cause for code in FOLLOWING[cause]}
    groups = []
    for cause, own in by_cause.items():
        stay = tuple(f for f in own if follows.get(f.code, cause) == cause)
        if stay:
            later = tuple(f for f in findings if follows.get(f.code) == cause and f not in own)
            groups.append(FindingGroup(cause, stay, later))
    return tuple(sorted(groups, key=lambda g: (SEVERITIES.index(g.severity), -len(g.findings))))


def _about(code: str) -> str:
    """What a rule is about, in one line."""
    return READING[code] if code in READING else RULES[code].about
