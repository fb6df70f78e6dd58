"""Printed results of papers recomputed: a folder a paper, found by its `results.toml` and described by its `STUDY`.

basis          What a recomputed number rests on, found by an experiment: all numbers of the paper are replaced by other
               ones
case           A case: one paper's tables and printed results under one set of errata, from which formulas recompute
               numbers
compare        Every printed number with its verdict: recomputed without errata, then with the fewest that explain it
kr30ha         The KR 30 HA report recomputed: points, matrices, equations of motion, program
lwr4           The LWR-IV exercise recomputed
lwr4plus       The LWR 4+ paper recomputed: worst-case inertias, gains, both controllers on IST
named_results  What a result of a user's own paper may be: a quantity of the arm by name, or an expression of such and
               of columns
own_paper      A user's own paper: the printed results in its data file, `[[result]]`, recomputed and judged without any
               Python
own_runs       Closed loops of a user's own paper, `[run.NAME]`, whose errors, torques and speeds are printed results
paper_page     The report page of a paper: printed numbers beside ours, errata with proofs, checks, audits, files
paper_study    A paper with its formulas and proofs, and the result of reproducing it
papers         Which papers can be reproduced: each folder of this package with a `results.toml`, described by its
               `STUDY`
published_sets  Proofs of the errata of published sets: each computed from cells with its own erratum alone, or with
               none
report         A report as one HTML file that loads nothing and can be read without a script
reproduce      A paper reproduced in a folder: its study, every number with its verdict, the errata with their proofs,
               the page
wam7           The WAM paper recomputed: its eight simulations with friction
"""
