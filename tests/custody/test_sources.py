"""What is said of the sources and of their errors is what stands in the data files."""

from collections import Counter
from pathlib import Path

import pytest

from lwr_dyn.arms.papers.catalog import open_paper, studied
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.arms.papers.schema import DOCUMENT_KINDS
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.reproduction.case import CONTRADICTION, CORRECTION
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import studies

ROOT = Path(__file__).resolve().parents[2]
WEIGHTS = ("model", "result", "text")
STATUSES = ("proven", "likely", "open")


def counts(robot):
    """Weight -> number of all errata, and of those that are proven."""
    errata = open_paper(robot).errata
    return {
        weight: [sum(e.severity == weight and e.status in of for e in errata) for of in (STATUSES, ("proven",))]
        for weight in WEIGHTS
    }


def test_every_source_says_what_it_is_of_when_and_how_it_was_read():
    for robot in studied():
        document = open_paper(robot).document
        assert document["kind"] in DOCUMENT_KINDS
        assert document["year"] == "not known" or 1950 < int(document["year"]) < 2100
        assert document["place"]
        assert "text recognition" in document["text"]


def test_the_page_lists_every_document_that_numbers_are_from():
    page = (ROOT / "docs" / "papers.md").read_text(encoding="utf-8")
    rows = page.partition("<!-- sources -->\n")[2].partition("\n\n")[0].splitlines()[2:]
    papers = [(robot, open_paper(robot)) for robot in studied()]
    listed = [
        (robot, {**x, "gives": x.get("gives", x.get("says", ""))})
        for robot, p in papers
        for x in (p.document, *p.sources)
    ]
    keys = ("title", "kind", "year", "place", "gives")
    assert rows == [f"| `{robot}` | {' | '.join(x[key] for key in keys)} |" for robot, x in listed]


SOURCE = """
[[source]]
title = "A sheet"
kind = "maker's sheet"
year = "1999"
place = "a shelf"
text = "read"
gives = "masses"
"""


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (("maker's sheet", "blog"), r"source\[0\]\.kind: 'blog'; allowed: one of paper"),
        (('year = "1999"', ""), r"source\[0\]\.year: missing"),
        (('gives = "masses"', 'give = "masses"'), r"source\[0\]\.gives: missing"),
        (('text = "read"', 'text = "read"\npage = "3"'), r"source\[0\]\.page: unknown"),
    ],
)
def test_a_source_says_all_that_is_asked_and_nothing_else(change, fault):
    text = (ROOT / "lwr_dyn" / "arms" / "papers" / "lwr4.toml").read_text(encoding="utf-8")
    parse_paper(text + SOURCE, "lwr4.toml")
    with pytest.raises(PaperError, match=fault):
        parse_paper(text + SOURCE.replace(*change), "lwr4.toml")


def test_a_kind_that_does_not_exist_is_refused_with_those_that_do():
    text = (ROOT / "lwr_dyn" / "arms" / "papers" / "lwr4.toml").read_text(encoding="utf-8")
    with pytest.raises(PaperError, match=r"document\.kind: 'blog'; allowed: one of paper, maker's sheet"):
        parse_paper(text.replace('kind = "exercise"', 'kind = "blog"', 1), "lwr4.toml")


def test_the_page_counts_errata_by_weight_and_kind_of_source():
    page = (ROOT / "docs" / "papers.md").read_text(encoding="utf-8")
    lines = page.partition("<!-- counts: errata -->\n")[2].splitlines()[2:]
    for robot, line in zip(studied(), lines[: len(studied())], strict=True):
        cells = [f"{every}, {proven}" if every else "0" for every, proven in counts(line.split("`")[1]).values()]
        kind = open_paper(line.split("`")[1]).document["kind"]
        assert line == f"| `{line.split('`')[1]}` | {kind} | {' | '.join(cells)} |", robot
    assert {line.split("`")[1] for line in lines[: len(studied())]} == set(studied())


def test_the_readme_counts_what_is_proven():
    proven = Counter()
    for robot in studied():
        for weight, (_, count) in counts(robot).items():
            proven[weight] += count
            proven[open_paper(robot).document["kind"]] += count
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    whole = proven.total() // 2
    says = (
        f"{whole} are proven, {proven['paper']} in two papers and {proven['course report']} in a course report; "
        f"{proven['model']} of the {whole} change the model, {proven['result']} a result, {proven['text']} are slips"
    )
    assert says in readme


@pytest.mark.slow
def test_the_page_counts_contradictions():
    shown = Counter()
    for robot in studies():
        study = paper_study(robot)
        shown.update(prove(study.data).kind for prove in study.proofs.values())
    likely = sum(
        e.id in paper_study(robot).proofs and e.status != "proven"
        for robot in studies() for e in paper_study(robot).data.errata
    )  # fmt: skip
    page = " ".join((ROOT / "docs" / "papers.md").read_text(encoding="utf-8").split())
    assert f"{shown[CORRECTION] - likely} show what is right; {shown[CONTRADICTION]} show a contradiction" in page


NOT_CITED = {"public ROS packages of the arm", "KUKA KR 30 HA, data sheet, as Appendix A of the report"}
"""Not one document, and part of another."""


def test_the_citation_lists_the_sources():
    import yaml

    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    listed = {x["title"]: x for x in citation["references"]}
    assert len(listed) == len(citation["references"])
    papers = [open_paper(robot) for robot in studied()]
    cited = {x["title"]: x for paper in papers for x in (*paper.sources, paper.document)}
    assert set(listed) == set(cited) - NOT_CITED
    for title, entry in listed.items():
        assert str(entry.get("year", "not known")) == cited[title]["year"]
        place = cited[title]["place"]
        assert entry.get("doi", "") == (place.removeprefix("doi:") if place.startswith("doi:") else "")
        assert entry.get("url", "") == (place if place.startswith("https:") else "")
