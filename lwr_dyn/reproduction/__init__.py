"""Printed results of papers recomputed: a folder a paper, found by its `results.toml` and described by its `STUDY`.

papers       Study, StudyOption: how a paper is reproduced, `studies()` finds them; reader of `results.toml`
case         PaperData and PaperCase: tables and results under a set of errata; PaperFormula, formulas that all papers
             share; the ledger of errata with their proofs
paper_study  PaperStudy: data, formulas and proofs of a paper; Reproduction: the result; figures.json
compare      every printed number and expression beside the recomputed one, with its verdict
basis        what a recomputed number rests on: computed, structural or repeated in print
reproduce    `reproduce`: one paper or all into a folder; lint, conventions and sensitivity as sections of the page
paper_page   the report page of a paper; counts of verdicts and errata as tables
report       the page as one HTML file
"""
