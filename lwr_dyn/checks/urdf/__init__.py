"""Faults in URDF files: each link, joint and shape as written, with its place, the reason and what to write instead.

    from lwr_dyn.checks.urdf.lint import lint_file
    for finding in lint_file("arm.urdf").findings: print(finding.place, finding.level, finding.message)

- `lint`: `lint_file`: a file judged by every rule; `rules`: the registry of the rules; `finding`: `UrdfFinding`
- `xml_tree`, `attribute_numbers`, `elements`, `document`: the file's contents with places
- `xacro_places`: places through macros
- `schema_rules` (with `vocabulary`), `tree_rules`, `joint_rules`, `angle_rules`, `inertial_rules` (with
  `welded_links`), `unit_rules`, `mesh_file_rules` (with `mesh_paths`): rules that need no shape
- `shape_rules`, `inertia_shape_rules`, `static_rules` and what they use (`bodies`, `hulls`, `meshes`, `judgement`,
  `undoings`, ...): rules that hold the file against the hulls of its shapes, and efforts against weights
- `grouping`, `report_text`, `sarif`: outputs; `lint_files`: the part of `lwr-dyn lint` that is about URDFs
"""
