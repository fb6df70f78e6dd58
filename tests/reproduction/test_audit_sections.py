"""What other rooms find stands on a paper's page and in its record."""

import numpy as np

from lwr_dyn.reproduction import audit_sections
from lwr_dyn.reproduction.rooms import room


def test_the_lint_finds_slips_that_the_errata_name():
    section, record = audit_sections.lint_section(room("lwr4plus"))
    for erratum in ("rotor-inertia-power", "table2-rows", "table2-c5z"):
        assert f"[erratum {erratum}]" in section.text
    assert len(record) == len(section.text.splitlines())


def test_the_resolver_finds_the_sign_of_the_wams_products_and_the_joints_of_the_kr30ha():
    section, lines = audit_sections.resolver_section("wam7")
    assert "products of inertia +integral (decided by second tensors)" in section.text
    assert section.text.splitlines() == "\n".join(lines).splitlines()
    assert audit_sections.resolver_section("kr30ha")[1]
    assert audit_sections.resolver_section("lwr4") is None
    assert audit_sections.spread_section("kr30ha") is None


def test_parts_that_a_paper_has_not_are_left_out_and_shades_are_shares():
    parts, record = audit_sections.sections_of(room("lwr4"), with_spread=True)
    assert [part.id for part in parts] == list(record) == ["lint"]
    shades = audit_sections._shades(np.array([[1.0, 2.0], [4.0, np.nan]]))
    assert shades == ((0.0, 0.25), (0.75, 0.0))


def test_the_evidence_of_table_iv_decides_the_lwr4plus():
    section, _ = audit_sections.resolver_section("lwr4plus")
    assert "tensors are about the centre of mass (decided by published numbers)" in section.text
