"""The conventions of a table that states none: every reading, ranked, and what decides it.

- `ranking`: `rank_readings` -> `RankedReadings`; `ranking_text`, `criteria_text`, `decisions`: the result in words
- `printed_table`, `evidence`, `evidence_file`: the printed cells, and what is published beside them
- `choices`, `hypotheses`, `candidates`: conventions, the bodies that follow from them, readings and their order
- `contributions`, `search`, `mirror`, `frames`: criteria: published numbers, repeated links, vectors between frames
- `cell_corrections`, `global_maximum_check`: single wrong cells; the largest B_ii checked by a global search
- `joint_zero`: zero, direction and DH convention of joints from the poses of a data sheet
"""
