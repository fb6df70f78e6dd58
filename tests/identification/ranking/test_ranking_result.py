"""What a ranking says."""

from lwr_dyn.identification.ranking.rank import rank


def test_the_document_says_source_filter_load_and_what_is_no_body():
    found = rank("panda", "panda_salerno", ["fer", "gaz"], free=["load"])
    text = found.document.text()
    assert text.startswith("gaz leaves 0.393 N m of 10.2 N m of torque, fer 1.015; least squares 0.306")
    for words in ("not stated", "BSD-3-Clause", "filter: 5 Hz", "no: link_4", "+0.76", "least squares"):
        assert words in text
    record = found.document.record()
    assert [row["set"] for row in record["sets"]] == ["gaz", "fer", "least squares"]
    assert record["free"] == ["load"]
    assert len(record["sets"][0]["left"]) == 2
    assert repr(found).startswith("Ranking(gaz leaves")
    assert "gaz leaves" in found._repr_html_()


def test_gains_that_the_log_does_not_show_are_question_marks():
    text = rank("ur10", "ur10_salerno", ["maker"], free=["rotor", "gain"]).document.text()
    line = next(line for line in text.splitlines() if "over those of the log" in line)
    assert " ? " in f"{line} "
    assert "1.0" in line
