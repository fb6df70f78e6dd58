"""`reproduce`: one paper or all, the same bytes twice, options refused where they are ignored; what audits show."""

import copy
import json
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.reproduction import reproduce
from lwr_dyn.reproduction.paper_study import Reproduction, paper_study, study_document
from lwr_dyn.reproduction.papers import studies
from tests.reproduction.pages import faults, lost


@pytest.mark.slow
def test_a_second_run_writes_the_same_results_byte_for_byte_and_the_same_page(tmp_path, browser):
    made = [reproduce.reproduce("lwr4", tmp_path / name) for name in ("a", "b")]
    for file in ("results.json", "report.html"):
        texts = [(tmp_path / name / file).read_bytes() for name in ("a", "b")]
        assert texts[0] == texts[1]
        assert str(tmp_path).encode() not in texts[0]
    assert all(outcome.holds for outcome in made)
    assert lost(tmp_path / "a") == []
    assert faults(browser, tmp_path / "a" / "report.html", wide=3_000, narrow=5_000) == []
    record = json.loads((tmp_path / "a" / "results.json").read_text())
    assert record["counts"]["printed"]["computed"] == {"all": 12, "reproduced": 12, "after erratum": 0, "differs": 0}
    assert made[0].document.text().startswith(f"{record['summary']}\n")
    assert record["summary"] in (tmp_path / "a" / "report.html").read_text()


ONLY = "given for {}; allowed: only for lwr4plus"
REFUSED = [
    *((paper, {"timing": "smooth"}, f"timing: {ONLY}") for paper in ("lwr4", "wam7", "kr30ha", "all")),
    *((paper, {"fit_arm_angle": True}, f"fit-arm-angle: {ONLY}") for paper in ("lwr4", "wam7", "kr30ha", "all")),
    *((paper, {"sensitivity": True}, f"sensitivity: {ONLY}, wam7, all") for paper in ("lwr4", "kr30ha")),
    ("lwr4plus", {"timing": "slow"}, "timing: 'slow'; allowed: .*smooth"),
    ("lwr4plus", {"speed": 2}, "option: 'speed'; allowed: .*timing"),
]


@pytest.mark.parametrize(("paper", "option", "message"), REFUSED)
def test_options_are_refused_where_they_have_no_meaning_and_nothing_is_written(tmp_path, paper, option, message):
    with pytest.raises(OptionError, match=message.format(paper)):
        reproduce.reproduce(paper, tmp_path / "out", **option)
    assert not (tmp_path / "out").exists()


def test_an_unknown_paper(tmp_path):
    with pytest.raises(UnknownNameError, match="no paper to reproduce named 'lwr9'"):
        reproduce.reproduce("lwr9", tmp_path / "out")


def test_all_papers_in_a_folder_each_and_one_table(tmp_path, monkeypatch):
    made = []

    def one(study, folder, *_):
        made.append((study.name, folder.name))
        verdicts = {"all": 2, "reproduced": 1, "after erratum": 1, "differs": 0}
        kinds = {"all": 9, "differs": 0, "not reproducible": 0, "under assumed conditions": {"all": 3, "near": 1}}
        kinds |= dict.fromkeys(("computed", "structural", "repeated in print"), verdicts)
        counts = {"printed": kinds, "derived": kinds, "errata": {"all": 1, "proven": 1, "proofs that hold": 1}}
        return Reproduction(study.name != "wam7", study_document(counts=counts))

    monkeypatch.setattr(reproduce, "ProcessPoolExecutor", lambda *_, **__: ThreadPoolExecutor(1))
    monkeypatch.setattr(reproduce, "_one", one)
    outcome = reproduce.reproduce("all", tmp_path)
    assert sorted(made) == sorted((paper, paper) for paper in studies())
    assert not outcome.holds
    (total,) = (line for line in outcome.document.text().splitlines() if line.startswith("all "))
    assert total.split()[1:] == ["36", "8", "4", "4", "0", "8", "8", "12", "4", "0", "36", "8", "4", "4"]
    assert list(json.loads((tmp_path / "results.json").read_text())["papers"]) == list(studies())


def test_a_number_that_differs_is_listed_and_fails_the_paper(tmp_path, monkeypatch):
    study = paper_study("lwr4")
    raw = copy.deepcopy(dict(study.data.results.raw))
    raw["tool"]["cells"]["position"][0] = "-0.3001"
    monkeypatch.setattr(reproduce, "paper_study", lambda _: study.with_data(results=raw))
    outcome = reproduce.reproduce("lwr4", tmp_path)
    assert not outcome.holds
    assert "tool.position[0]" in outcome.document.text()
    assert "+0.0001" in outcome.document.text()


@pytest.mark.slow
def test_an_incomplete_folder_is_marked_until_it_is_complete(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(reproduce, "write_report", interrupted)
        with pytest.raises(KeyboardInterrupt):
            reproduce.reproduce("lwr4", tmp_path / "out")
    assert (tmp_path / "out" / reproduce.INCOMPLETE).is_file()
    reproduce.reproduce("lwr4", tmp_path / "out")
    assert not (tmp_path / "out" / reproduce.INCOMPLETE).exists()


def test_the_lint_finds_faults_that_the_errata_name():
    section, record = reproduce.lint_section("lwr4plus")
    for erratum in ("rotor-inertia-power", "table2-rows", "table2-c5z"):
        assert f"[erratum {erratum}]" in section.text
    assert len(record) == len(section.text.splitlines())


@pytest.mark.slow
def test_the_resolver_finds_the_sign_of_the_wams_products_and_the_joints_of_the_kr30ha():
    section, lines = reproduce.convention_section("wam7", of_tensors=True)
    assert "products of inertia +integral (decided by second tensors)" in section.text
    assert section.text.splitlines() == "\n".join(lines).splitlines()
    assert reproduce.convention_section("kr30ha", of_tensors=False)[1]


def test_parts_that_a_paper_has_not_are_left_out(monkeypatch):
    parts, record = reproduce.audit_sections(paper_study("lwr4"), with_sensitivity=False)
    assert [part.id for part in parts] == list(record) == ["lint"]
    monkeypatch.setattr(reproduce, "sensitivity_section", lambda *asked: (SimpleNamespace(id="spread"), asked))
    parts, record = reproduce.audit_sections(paper_study("lwr4"), with_sensitivity=True)
    assert ([part.id for part in parts], record["spread"]) == (["lint", "spread"], ("lwr4", "printed"))


@pytest.mark.slow
def test_the_evidence_of_table_iv_decides_the_lwr4plus():
    section, _ = reproduce.convention_section("lwr4plus", of_tensors=True)
    assert "tensors are about the centre of mass (decided by published numbers)" in section.text


def test_a_check_is_a_line_with_what_fails():
    def line(*holds):
        verdicts = [SimpleNamespace(name=f"c{k}", holds=x) for k, x in enumerate(holds)]
        return reproduce.check_line(SimpleNamespace(robot="r", reading="p", verdicts=verdicts))

    assert [line(True), line(True, True), line(False, True, False)] == [
        "check r, reading p: 1 holds", "check r, reading p: 2 hold", "check r, reading p: 1 holds, FAIL: c0, c2",
    ]  # fmt: skip
