"""Checks of published tables and of robots' files.

- `lint`: faults that need no model to be seen
- `urdf`: faults in URDF files, each with its place
- `conventions`: the conventions under which a table can be read
- `sensitivity`: one task under all readings of a robot
- `datasheet`: poses, ranges, reach, envelope volume and mass against the maker's data sheet, a check of `lwr-dyn check`
- `printed_number`, `study_tasks`: numbers as printed; tasks that papers set
- `envelope`, `envelope_arcs`: section, reach and volume that the wrist centre can reach
"""
