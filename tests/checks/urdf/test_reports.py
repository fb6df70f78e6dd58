from lwr_dyn.checks.urdf.document import UrdfFinding
from lwr_dyn.checks.urdf.reports import grouped
from lwr_dyn.checks.urdf.xml_tree import Place


def finding(code: str, subject: str, severity="error", cause: str = "") -> UrdfFinding:
    return UrdfFinding("x", "", Place("f", 1, 1), subject, cause=cause, severity=severity, code=code)


GRAMS = finding("mass-grams", "link a", cause="masses in g")


def test_what_follows_from_a_cause_stands_in_its_group_only_at_the_same_link():
    here, there = finding("density", "link a", "warning"), finding("density", "link b", "warning")
    weight = finding("effort-weight", "joint c", "warning")
    first, second = grouped([here, there, weight, GRAMS])
    assert (first.cause, first.findings, first.following) == ("masses in g", (GRAMS,), (here, weight))
    assert second.findings == (there,)


def test_no_finding_is_lost_and_errors_and_large_groups_come_first():
    notes = [finding("inertial-equal", f"link {k}", "note") for k in range(9)]
    warnings = [finding("limit-equal", f"joint {k}", "warning") for k in range(2)]
    more = [finding("axis-not-unit", f"joint {k}", "warning") for k in range(3)]
    groups = grouped([*notes, *warnings, *more, GRAMS])
    assert [group.codes for group in groups] == [
        ("mass-grams",), ("axis-not-unit",), ("limit-equal",), ("inertial-equal",)
    ]  # fmt: skip
    assert sum(len(group.findings) + len(group.following) for group in groups) == 15


def test_a_group_is_as_severe_as_its_worst_finding():
    (group,) = grouped([finding("density", "link a", "note"), finding("density", "link b", "warning")])
    assert group.severity == "warning"
