"""What stands both in a data file and among the printed results is the same in both."""

from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import printed_tables


def test_table_ii_of_the_lwr4plus():
    origins = paper_study("lwr4plus").data.tables["frames"]["origin"]["values"]
    printed = printed_tables("lwr4plus")["table_ii"]["r"]
    assert [[float(x) for x in row] for row in printed] == [[float(x) for x in row] for row in origins]


def test_what_the_text_repeats_of_tables_vii_and_viii():
    tables = printed_tables("lwr4plus")
    assert tables["table_iv"]["b"] == tables["table_iv_configurations"]["at_most"]
    assert tables["table_iv_configurations"]["at_most"] == tables["table_iv_configurations"]["at_least"]


def test_appendix_a_of_the_kr30ha():
    ratings, printed = paper_study("kr30ha").data.tables["ratings"], printed_tables("kr30ha")["appendix_a"]
    assert float(printed["reach"][0]) == ratings["reach"]["values"]
    assert float(printed["volume"][0]) == ratings["envelope_volume"]["values"]


def test_expressions_of_the_kr30ha():
    block = paper_study("kr30ha").data.results.blocks["expressions"]
    listed = printed_tables("kr30ha", "motion")["expression"]
    texts = ["; ".join(e["printed"]) if isinstance(e["printed"], list) else e["printed"] for e in listed]
    assert [cell.printed for cell in block.cells] == texts
    assert [cell.row for cell in block.cells] == [e["name"] for e in listed]
    assert set(block.errata) == {fault["erratum"] for e in listed for fault in e["errors"]}


def test_points_of_the_kr30ha():
    tables, program = printed_tables("kr30ha"), printed_tables("kr30ha", "program")
    for k, name in enumerate(("point_1", "point_2")):
        assert tables["coordinates"][name] == tables[name]["xyz"] == program["points"][k]["xyz"]
