"""Printed results of papers recomputed: a folder a paper, found by its `results.toml` and described by its `STUDY`.

study            Study, StudyOption: how a paper is reproduced; `studies()` finds them
paper_study      PaperStudy: data, formulas and proofs of a paper; Reproduction: the result
reproduce        `reproduce`: one paper or all into a folder
results          reader of `results.toml`: PrintedCell, ResultBlock, Results
case             PaperData and PaperCase: tables and results under a set of errata; PaperFormula
compare          one block of printed numbers against the recomputed ones
basis            what a recomputed number rests on: computed, structural or repeated in print
other_numbers    a case with other numbers of the same kind
verdicts         all numbers of a paper with their verdicts
figure_file      figures.json: what all figures show, written once
ledger           errata with their proofs
summary          counts of verdicts and errata as tables
quantities       formulas that all papers share
expressions      printed expressions compared by value
audit_sections   lint, conventions and sensitivity as sections of the page
paper_page       the report page of a paper
report           the page as one HTML file
command          `lwr-dyn reproduce`
"""
