"""Faults in URDF files: each link, joint and shape as written, with its place, the reason and what to write instead.

    from lwr_dyn.checks.urdf.lint import lint_file
    for finding in lint_file("arm.urdf").findings: print(finding.place, finding.level, finding.message)

lint                 `lint_file`: a file judged by every rule; `RULES`
reports              findings grouped by cause; text, SARIF, annotations; what `lwr-dyn lint` does with URDFs
xml_tree, elements   XML with places, also through macros; links and joints as written
document             `UrdfDocument`: the file's links, joints and poses; `UrdfFinding`
schema_rules, joint_rules, inertial_rules
                     rules that need no shape
shape_rules, inertia_shape_rules, static_rules
                     rules that hold the file against the hulls of its shapes, and efforts against weights
hulls, judgement, undoings
                     the hulls, each link held against its own, the slip that explains what is odd
"""
