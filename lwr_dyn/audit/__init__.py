"""Checks of published tables.

- `lint`: faults that need no model to be seen
- `conventions`: the conventions under which a table can be read
- `sensitivity`: one task under all readings of a robot
"""
