"""Findings grouped by cause: one line for what one slip did to many links, the largest first."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from lwr_dyn.checks.urdf.finding import SEVERITIES, FindingSeverity, UrdfFinding
from lwr_dyn.checks.urdf.rules import READING, RULES

FOLLOWING = {
    "masses in g": ("density", "effort-weight", "inertia-spread", "inertia-bound", "inertia-slip"),
    "origins in mm": ("bodies-apart", "joint-off-bodies", "effort-weight"),
    "centres of mass in mm": ("centre-outside", "effort-weight"),
    "rpy in degrees": ("bodies-apart", "joint-off-bodies", "effort-weight"),
}
"""Causes, and rules whose findings follow from them: they stand in the group of the cause."""
_FURTHER = ("effort-weight", "bodies-apart", "joint-off-bodies")
"""Rules that also find at other links and joints what one link did; the others must be at the same link."""


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
    causes = {cause: {f.subject for f in own} for cause, own in by_cause.items() if cause in FOLLOWING}
    follows = [(f, cause) for f in findings if (cause := _followed(f, causes))]
    absorbed = {id(f) for f, _ in follows}
    groups = []
    for cause, own in by_cause.items():
        stay = tuple(f for f in own if id(f) not in absorbed)
        if stay:
            groups.append(FindingGroup(cause, stay, tuple(f for f, into in follows if into == cause)))
    return tuple(sorted(groups, key=lambda g: (SEVERITIES.index(g.severity), -len(g.findings))))


def _followed(finding: UrdfFinding, causes: Mapping[str, Collection[str]]) -> str:
    """The cause that a finding follows from; empty where there is none."""
    for cause, subjects in causes.items():
        near = finding.code in _FURTHER or finding.subject in subjects
        if finding.code in FOLLOWING[cause] and finding.cause not in causes and near:
            return cause
    return ""


def _about(code: str) -> str:
    """What a rule is about, in one line."""
    return READING[code] if code in READING else RULES[code].about
