"""The rules by code; each is one function of a document, and its docstring is what `--explain CODE` prints.

A row's facts: the default severity, and whether the rule judges links also where no joint moves them.
"""

from collections.abc import Callable, Iterable
from inspect import getdoc

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.finding import FindingSeverity, UrdfFinding
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
        "number-malformed": rule("schema_rules:malformed_numbers", "error", "nan, text, or too few numbers"),
        "joint-type": rule("schema_rules:joint_types", "error", "a type of joint that the format does not have"),
        "element-twice": rule("schema_rules:elements_twice", "warning", "an element that counts once, written twice"),
        "tag-unknown": rule("schema_rules:unknown_tags", "note", "a tag that no reader knows at this place"),
        "attribute-unknown": rule("schema_rules:unknown_attributes", "note", "an attribute that no reader knows"),
        "link-unknown": rule("tree_rules:unknown_links", "error", "a joint's parent or child that is no link"),
        "link-carried-twice": rule("tree_rules:carried_twice", "error", "a link that two joints carry"),
        "tree-roots": rule("tree_rules:several_roots", "error", "several links without a parent"),
        "tree-loop": rule("tree_rules:loops", "error", "joints that follow each other in a circle"),
        "mimic-unknown": rule("tree_rules:unknown_mimics", "error", "a joint that mimics what is not there"),
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
        "rpy-degrees": rule("angle_rules:angles_in_degrees", "error", "roll, pitch, yaw in degrees"),
        "fixed-limits": rule("joint_rules:fixed_with_limits", "warning", "a fixed joint with limits"),
        "inertial-missing": rule("inertial_rules:inertials_missing", "error", "a moved link without mass"),
        "mass-negative": rule("inertial_rules:masses_negative", "error", "a mass below 0"),
        "mass-zero": rule("inertial_rules:masses_zero", "error", "no mass, but an inertia"),
        "mass-grams": rule("unit_rules:masses_in_grams", "error", "a mass that looks like grams"),
        "com-millimetres": rule("unit_rules:centres_in_millimetres", "error", "a centre of mass in millimetres"),
        "inertia-not-positive": rule("inertial_rules:tensors_not_positive", "error", "a moment below 0"),
        "inertia-triangle": rule("inertial_rules:tensors_triangle", "error", "a tensor that no body has"),
        "inertia-zero": rule("inertial_rules:tensors_zero", "warning", "a mass with a tensor of zeros"),
        "inertial-placeholder": rule("inertial_rules:placeholders", "warning", "a stand-in for an unknown inertia"),
        "inertial-equal": rule("inertial_rules:inertials_equal", "note", "the inertial of the neighbour"),
        "mesh-missing": rule("mesh_file_rules:meshes_missing", "error", "a mesh file that is not there"),
        "mesh-package": rule("mesh_file_rules:packages_missing", "note", "meshes of a package that is not there"),
        "mesh-scale": rule("mesh_file_rules:mesh_scales", "error", "a scale of 0, or an odd one"),
        "shape-size": rule("mesh_file_rules:shape_sizes", "error", "a shape with a length of 0 or less"),
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
        # statics
        "effort-weight": rule("static_rules:effort_against_weight", "warning", "effort against the weight to hold"),
        "effort-unlike": rule("static_rules:unlike_others", "warning", "an effort far from all others"),
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
    if code not in RULES.names:
        raise UnknownNameError("code of a rule", code, codes())
    row = RULES[code]
    text = getdoc(RULES.load(code)) or ""
    return f"{code} ({severity_of(code)}): {row.about}\n\n{text}"
