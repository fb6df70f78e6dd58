"""A URDF judged by every rule: the findings with their severity, without those that the user ignores.

A rule is one function of a document, a row by its code; its docstring is what `--explain CODE` prints. A row's facts
are the default severity, and whether the rule judges links also where no joint moves them.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from inspect import getdoc
from pathlib import Path

import numpy as np

from lwr_dyn.checks.urdf import reader_rules, shape_rules
from lwr_dyn.checks.urdf.document import SEVERITIES, FindingSeverity, UrdfDocument, UrdfFinding, read_document
from lwr_dyn.checks.urdf.xml_tree import Place, XmlElement
from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.foundation.registry import Registry, Row

UrdfRule = Callable[[UrdfDocument], Iterable[UrdfFinding]]
_HERE = "lwr_dyn.checks.urdf."

READING = {
    "xml-syntax": "text that is no XML",
    "xml-encoding": "text that is no UTF-8",
    "xacro-refused": "macros that xacro does not expand",
}
"""Codes of reading itself, before any rule can run."""


def rule(target: str, severity: FindingSeverity, about: str) -> Row:
    """A row: "module:function" in this package, the default severity, one line for lists."""
    return Row(_HERE + target, about, facts={"severity": severity})


RULES: Registry[UrdfRule] = Registry(
    "urdf_rule",
    {
        "root-tag": rule("schema_rules:root_tag", "error", "the outermost element is not <robot>, or is empty"),
        "name-missing": rule("schema_rules:missing_names", "error", "a robot, link or joint without a name"),
        "name-twice": rule("schema_rules:names_twice", "error", "two links or two joints of one name"),
        "tag-misspelt": rule("schema_rules:misspelt_tags", "error", "a tag a letter or two off a known one"),
        "attribute-misspelt": rule(
            "schema_rules:misspelt_attributes", "error", "an attribute a letter or two off a known one"
        ),
        "attribute-missing": rule("schema_rules:missing_attributes", "error", "an attribute that the format requires"),
        "element-missing": rule("schema_rules:missing_elements", "error", "an <inertial> without mass or inertia"),
        "number-malformed": rule("schema_rules:malformed_numbers", "error", "nan, text, or too few numbers"),
        "joint-type": rule("schema_rules:joint_types", "error", "a type of joint that the format does not have"),
        "element-twice": rule("schema_rules:elements_twice", "warning", "an element that counts once, written twice"),
        "tag-unknown": rule("schema_rules:unknown_tags", "note", "a tag that no reader knows at this place"),
        "xacro-leftover": rule("schema_rules:leftovers_of_xacro", "note", "a tag of xacro that readers pass over"),
        "attribute-unknown": rule("schema_rules:unknown_attributes", "note", "an attribute that no reader knows"),
        "link-unknown": rule("joint_rules:unknown_links", "error", "a joint's parent or child that is no link"),
        "link-carried-twice": rule("joint_rules:carried_twice", "error", "a link that two joints carry"),
        "tree-roots": rule("joint_rules:several_roots", "error", "several links without a parent"),
        "tree-loop": rule("joint_rules:loops", "error", "joints that follow each other in a circle"),
        "mimic-unknown": rule("joint_rules:unknown_mimics", "error", "a joint that mimics what is not there"),
        "limit-missing": rule("joint_rules:limits_missing", "error", "a joint without the limits that it needs"),
        "limit-degrees": rule("joint_rules:limits_in_degrees", "error", "position limits that look like degrees"),
        "limit-range": rule("joint_rules:limits_without_bound", "warning", "position limits that stand for none"),
        "limit-exchanged": rule("joint_rules:limits_exchanged", "error", "a lower limit above the upper one"),
        "limit-equal": rule("joint_rules:limits_equal", "warning", "equal limits: the joint cannot move"),
        "velocity-zero": rule("joint_rules:velocity_zero", "error", "a velocity limit of 0 or less"),
        "velocity-degrees": rule("joint_rules:velocity_in_degrees", "warning", "a speed that looks like deg/s"),
        "effort-zero": rule("joint_rules:effort_zero", "error", "an effort limit of 0 or less"),
        "axis-zero": rule("joint_rules:axes_zero", "error", "an axis without direction"),
        "axis-not-unit": rule("joint_rules:axes_not_unit", "warning", "an axis whose length is not 1"),
        "origin-millimetres": rule("joint_rules:origins_in_millimetres", "error", "a joint's origin in millimetres"),
        "rpy-degrees": rule("joint_rules:angles_in_degrees", "error", "roll, pitch, yaw in degrees"),
        "rpy-quaternion": rule("joint_rules:angles_of_quaternions", "warning", "parts of a quaternion as angles"),
        "fixed-limits": rule("joint_rules:fixed_with_limits", "warning", "a fixed joint with limits"),
        "inertial-missing": rule("inertial_rules:inertials_missing", "error", "a moved link without mass"),
        "mass-negative": rule("inertial_rules:masses_negative", "error", "a mass below 0"),
        "mass-zero": rule("inertial_rules:masses_zero", "error", "no mass, but an inertia"),
        "mass-grams": rule("inertial_rules:masses_in_grams", "error", "a mass that looks like grams"),
        "com-millimetres": rule("inertial_rules:centres_in_millimetres", "error", "a centre of mass in millimetres"),
        "inertia-not-positive": rule("inertial_rules:tensors_not_positive", "error", "a moment below 0"),
        "inertia-triangle": rule("inertial_rules:tensors_triangle", "error", "a tensor that no body has"),
        "inertia-zero": rule("inertial_rules:tensors_zero", "warning", "a mass with a tensor of zeros"),
        "inertial-placeholder": rule("inertial_rules:placeholders", "warning", "a stand-in for an unknown inertia"),
        "inertia-mirror": rule("mirror_rules:signs_unlike", "warning", "signs of products unlike the mirrored link"),
        "inertial-equal": rule("inertial_rules:inertials_equal", "note", "the inertial of the neighbour"),
        "mesh-missing": rule("shape_rules:meshes_missing", "error", "a mesh file that is not there"),
        "mesh-package": rule("shape_rules:packages_missing", "note", "meshes of a package that is not there"),
        "mesh-scale": rule("shape_rules:mesh_scales", "error", "a scale of 0, or an odd one"),
        "shape-size": rule("shape_rules:shape_sizes", "error", "a shape with a length of 0 or less"),
        # shapes
        "mesh-unreadable": rule("shape_rules:mesh_unreadable", "warning", "a mesh file that cannot be read"),
        "shapes-differ": rule("shape_rules:shapes_differ", "warning", "visual and collision in different units"),
        "bodies-apart": rule("shape_rules:bodies_apart", "warning", "bodies that do not meet at their joint"),
        "joint-off-bodies": rule("shape_rules:joint_off_bodies", "warning", "a joint outside both its bodies"),
        "joint-origin": rule("shape_rules:origins_doubted", "warning", "an origin that another sign or order mends"),
        "joint-axis": rule("shape_rules:axes_doubted", "note", "an axis that turns a body into its parent"),
        # mass, centre, inertia against the shapes
        "density": rule("inertia_shape_rules:density", "warning", "mass over volume that no arm has"),
        "centre-outside": rule("inertia_shape_rules:centre", "warning", "a centre of mass outside the shapes"),
        "centre-slip": rule("inertia_shape_rules:centre_slip", "warning", "a centre that one slip explains"),
        "mass-slip": rule("inertia_shape_rules:mass_fit", "warning", "a mass that fits neither volume nor inertia"),
        "inertia-spread": rule("inertia_shape_rules:spread", "warning", "an inertia too wide or narrow for the shapes"),
        "inertia-bound": rule("inertia_shape_rules:bound", "warning", "an inertia that no mass in the shapes has"),
        "inertia-slip": rule("inertia_shape_rules:slip", "warning", "an inertia that one slip explains"),
        # drives
        "damping-negative": rule("drive_rules:losses_negative", "error", "damping or friction below 0"),
        "armature-unread": rule("drive_rules:armatures_unread", "note", "a rotor inertia that nothing reads"),
        "travel-long": rule("drive_rules:travels_long", "warning", "a slide that travels further than its arm reaches"),
        "velocity-rpm": rule("drive_rules:velocities_in_rpm", "warning", "a speed that looks like rpm or deg/s"),
        "effort-weight": rule("drive_rules:effort_against_weight", "warning", "effort against the weight to hold"),
        "effort-unlike": rule("drive_rules:unlike_others", "warning", "an effort far from all others"),
        # all else that the reader refuses
        "reader-refuses": rule("reader_rules:refused", "error", "what no command of this package loads"),
    },
)
"""In the order of their findings: schema, tree, joints, inertials, shapes, drives, the reader."""


def severity_of(code: str) -> FindingSeverity:
    """The default severity of a rule; that of another package's rule is a warning where it states none."""
    severity: FindingSeverity = "error" if code in READING else RULES[code].facts.get("severity", "warning")
    return severity


def codes() -> tuple[str, ...]:
    """All codes that a finding can bear."""
    return (*READING, *RULES.names)


def about(code: str) -> str:
    """What a rule is about, in one line."""
    return READING[code] if code in READING else RULES[code].about


def explanation(code: str) -> str:
    """What a rule looks at and why; raises `UnknownNameError`."""
    if code in READING:
        return f"{code} (error): {about(code)}\n\nNo program can read such a file, so no other rule runs."
    if code not in RULES.names:
        raise UnknownNameError("code of a rule", code, codes())
    return f"{code} ({severity_of(code)}): {about(code)}\n\n{getdoc(RULES.load(code)) or ''}"


ALL = "all"
"""In a comment of the file: every code."""


@dataclass(frozen=True, slots=True, eq=False)
class LintReport:
    """The judgement of one file."""

    file: str
    findings: tuple[UrdfFinding, ...]
    """Errors, warnings, notes; each in the order of the rules and of the file."""
    remarks: tuple[str, ...]
    """What could not be judged, and why."""
    links: int
    moved: int
    """How many of the links a joint moves."""
    ignored: int
    """How many findings the user's `ignore` left out."""

    def count(self, severity: FindingSeverity) -> int:
        """How many findings have this severity."""
        return sum(f.level == severity for f in self.findings)

    def holds(self, strict: bool = False) -> bool:
        """No error; with `strict`, no warning either."""
        return not (self.count("error") or (strict and self.count("warning")))


def lint_file(
    path: str | Path,
    ignore: Collection[str] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> LintReport:
    """Judge a URDF or xacro file, whose arguments are `xacro_args`, without the codes to ignore.

    None of a xacro's code runs unless `trust_xacro` says that all of it may.

    Raises `FileAccessError`, `MissingPackageError` and `UrdfError` as `read_document`, `UnknownNameError` for a code to
    ignore that no rule has.
    """
    return lint_document(read_document(path, xacro_args, trust_xacro), ignore)


def lint_document(document: UrdfDocument, ignore: Collection[str] = ()) -> LintReport:
    """Judge a document; raises `UnknownNameError` as `lint_file`."""
    for code in ignore:
        if code not in codes():
            raise UnknownNameError("code of a rule", code, codes())
    found = _found(document)
    places = dict(_ignored_places(document.root))
    kept = [f for f in found if f.code not in ignore and not {f.code, ALL} & places.get(f.place, frozenset())]
    kept.sort(key=lambda f: SEVERITIES.index(f.level))
    moved = sum(link.name in document.moved for link in document.links)
    remarks = tuple(_remarks(document))
    return LintReport(document.file, tuple(kept), remarks, len(document.links), moved, len(found) - len(kept))


def _found(document: UrdfDocument) -> list[UrdfFinding]:
    """The findings of all rules, each once, with code and severity."""
    found = {(f.code, f.place, f.subject, f.what): replace(f, severity="error") for f in document.faults}
    if document.root is None:
        return list(found.values())
    with np.errstate(all="ignore"):
        for code in RULES.names:
            for finding in RULES.load(code)(document):
                named = replace(finding, code=code, severity=_severity(finding, code, document))
                found.setdefault((code, finding.place, finding.subject, finding.what), named)
    return reader_rules.unsaid(found.values())


def _remarks(document: UrdfDocument) -> Iterable[str]:
    """What could not be judged."""
    asked = {code for _, ignored in _ignored_places(document.root) for code in ignored}
    for code in sorted(asked - {ALL, *codes()}):
        yield f"a comment asks to ignore {code!r}: no rule has this code"
    if document.links and not document.has_mass:
        yield "no link has mass: kinematics only, nothing about mass and inertia is judged"
    elif document.links:
        yield from shape_rules.remarks(document)
    yield from reader_rules.remark(document)


def _severity(finding: UrdfFinding, code: str, document: UrdfDocument) -> FindingSeverity:
    """That of the finding or of its rule; of a link fixed to a moved one a level lower, of one that rests a note."""
    severity = finding.severity or severity_of(code)
    if not finding.link or finding.link in document.driven:
        return severity
    if finding.link in document.moved and severity == "error":
        return "warning"
    return "note"


def _ignored_places(root: XmlElement | None) -> Iterable[tuple[Place, frozenset[str]]]:
    """Every place where a comment of the file asks to ignore codes."""
    waiting = [root] if root is not None else []
    while waiting:
        element = waiting.pop()
        if element.ignored:
            yield element.place, element.ignored
        waiting += element.children
