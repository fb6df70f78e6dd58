"""`lwr-dyn rank`."""

import json


def test_it_ranks_and_writes_the_page(lwr_dyn_command, tmp_path):
    page = tmp_path / "panda.html"
    code, out, _ = lwr_dyn_command("rank", "panda", "--log", "panda_salerno", "--sets", "gaz,fer", "--html", str(page))
    assert code == 0
    assert "gaz leaves 0.393" in out
    assert f"wrote {page}" in out
    assert "torques against measurement" in page.read_text()


def test_json_has_the_sets(lwr_dyn_command):
    code, out, _ = lwr_dyn_command(
        "rank", "panda", "--log", "panda_salerno", "--sets", "gaz", "--free", "load", "--json"
    )
    record = json.loads(out)
    assert code == 0
    assert record["sets"][0]["set"] == "gaz"
    assert record["train_rows"] > record["test_rows"]


def test_computed_torques_and_missing_files_are_one_line(lwr_dyn_command):
    for log, words in (("ur10e_30s_target", "computed, not measured"), ("ur10e_30s", "github.com/shamilmamedov")):
        code, out, err = lwr_dyn_command("rank", "ur10e", "--log", log)
        assert (code, out) == (2, "")
        assert words in err
        assert len(err.splitlines()) == 1
