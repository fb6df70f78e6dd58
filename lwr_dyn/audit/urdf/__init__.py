"""Faults in URDF files: each link, joint and shape as written, with its place, the reason and what to write instead.

- `lint`: `lint_file`: a file judged by every rule; `rules`: the registry of the rules
- `xml_tree`, `elements`, `document`: the file's contents with places; `xacro_places`: through xacro's macros
- `finding`: `UrdfFinding`
- `schema_rules`: rules of the format
"""
