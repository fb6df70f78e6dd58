"""The rules by code; each is one function of a document, and its docstring is what `--explain CODE` prints.

A row's facts: the default severity, and whether the rule judges links also where no joint moves them.
"""

from collections.abc import Callable, Iterable
from inspect import getdoc

from lwr_dyn.audit.urdf.document import UrdfDocument
from lwr_dyn.audit.urdf.finding import FindingSeverity, UrdfFinding
from lwr_dyn.registry import Registry, Row

UrdfRule = Callable[[UrdfDocument], Iterable[UrdfFinding]]
_HERE = "lwr_dyn.audit.urdf."
READING = {"xml-syntax": "text that is no XML", "xml-encoding": "text that is no UTF-8"}
"""Codes of reading itself, before any rule can run."""


def rule(target: str, severity: FindingSeverity, about: str) -> Row:
    """A row: "module:function" in this package, the default severity, one line for lists."""
    return Row(_HERE + target, about, facts={"severity": severity})


RULES: Registry[UrdfRule] = Registry(
    "urdf_rule",
    {
        # schema
        "root-tag": rule("schema_rules:root_tag", "error", "the outermost element is not <robot>"),
        # shapes
        "mesh-unreadable": rule("shape_rules:mesh_unreadable", "warning", "a mesh file that cannot be read"),
        "shapes-differ": rule("shape_rules:shapes_differ", "warning", "visual and collision in different units"),
        "bodies-apart": rule("shape_rules:bodies_apart", "warning", "bodies that do not meet at their joint"),
        "joint-off-bodies": rule("shape_rules:joint_off_bodies", "warning", "a joint outside both its bodies"),
        # mass, centre, inertia against the shapes
        "density": rule("inertia_shape_rules:density", "warning", "mass over volume that no arm has"),
        "centre-outside": rule("inertia_shape_rules:centre", "warning", "a centre of mass outside the shapes"),
        "inertia-spread": rule("inertia_shape_rules:spread", "warning", "an inertia too wide or narrow for the shapes"),
        "inertia-bound": rule("inertia_shape_rules:bound", "warning", "an inertia that no mass in the shapes has"),
        "inertia-slip": rule("inertia_shape_rules:slip", "warning", "an inertia that one slip explains"),
        # statics
        "effort-weight": rule("static_rules:effort_against_weight", "warning", "effort against the weight to hold"),
    },
)
"""In the order of their findings: schema, tree, joints, inertials, shapes, statics."""


def severity_of(code: str) -> FindingSeverity:
    """The default severity of a rule; that of another package's rule is a warning where it states none."""
    severity: FindingSeverity = "error" if code in READING else RULES[code].facts.get("severity", "warning")
    return severity


def codes() -> tuple[str, ...]:
    """All codes that a finding can bear."""
    return (*READING, *RULES.names)


def explanation(code: str) -> str:
    """What a rule looks at and why; raises `UnknownNameError`."""
    if code in READING:
        return f"{code} (error): {READING[code]}\n\nNo program can read such a file, so no other rule runs."
    row = RULES[code]
    text = getdoc(RULES.load(code)) or ""
    return f"{code} ({severity_of(code)}): {row.about}\n\n{text}"
