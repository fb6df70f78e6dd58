"""The conventions of a table that states none: every reading, ranked, and what decides it.

ranking        `rank_readings` -> `RankedReadings`; `decisions`: what decides each choice
ranking_text   the result in words
printed_table  the printed cells, the conventions they leave open, the bodies of each choice
evidence       what is published beside the table
hypotheses     one choice of conventions for a whole table: frames, repeated links
candidates     readings of a hypothesis and their order; single wrong cells
search         bodies that give the published numbers
"""
