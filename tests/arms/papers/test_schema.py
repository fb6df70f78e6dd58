"""The schema agrees with the units; records of a paper convert to SI at every depth."""

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import RESULTS, TABLES, UNITS, Column, Erratum, Patch

RULES = {f"{table}.{name}": rule for table, columns in TABLES.items() for name, rule in columns.items()}


@pytest.mark.parametrize("name", RULES)
def test_every_quantity_of_the_schema_has_a_unit_in_si(name):
    for quantity in RULES[name].quantities:
        assert 1.0 in [factor for known, factor in UNITS.values() if known == quantity]


def test_columns_in_mixed_units_and_nested_rows_become_si():
    mixed = Column("limits.lower", (90.0, 50.0), ("deg", "mm"), "p. 1", "printed")
    np.testing.assert_array_equal(mixed.si(), [np.pi / 2, 0.05])
    tensor = Column("inertial.inertia", (((1.0, 2.0), (3.0, 4.0)),), ("kg mm^2",), "p. 1", "printed")
    np.testing.assert_allclose(tensor.si(), [[[1e-6, 2e-6], [3e-6, 4e-6]]], rtol=1e-15)


def test_patches_of_an_erratum_are_of_tables_or_of_results():
    table, result = Patch("dh.a.values[0]", 1, 2), Patch(f"{RESULTS}table_v.x[0]", 3, 4)
    erratum = Erratum("id", "p. 1", "1", "2", "why", "effect", "proven", (table, result))
    assert (erratum.of_tables(), erratum.of_results()) == ((table,), (result,))


def test_numbers_of_a_paper_are_in_si_and_absent_columns_are_empty():
    paper = open_paper("lwr4plus")
    assert paper.numbers("inertial.mass") == tuple(paper.columns["inertial.mass"].si())
    assert paper.cell("inertial.mass", 2) == paper.numbers("inertial.mass")[2]
    assert (paper.numbers("no.column"), paper.cell("no.column")) == ((), None)
    assert paper.reading_names[0] == paper.default_reading
    assert sorted(paper.reading_names) == sorted(paper.readings)
    assert repr(paper) == f"Paper('lwr4plus', reading={paper.reading.name!r}, file={paper.file!r})"
