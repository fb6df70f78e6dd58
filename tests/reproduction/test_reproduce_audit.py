"""What audits show stands on a paper's page and in its record."""

import pytest

from lwr_dyn.reproduction import reproduce
from lwr_dyn.reproduction.paper_study import paper_study


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


def test_parts_that_a_paper_has_not_are_left_out():
    parts, record = reproduce.audit_sections(paper_study("lwr4"), with_sensitivity=False)
    assert [part.id for part in parts] == list(record) == ["lint"]


@pytest.mark.slow
def test_the_evidence_of_table_iv_decides_the_lwr4plus():
    section, _ = reproduce.convention_section("lwr4plus", of_tensors=True)
    assert "tensors are about the centre of mass (decided by published numbers)" in section.text
