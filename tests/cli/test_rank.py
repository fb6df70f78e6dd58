"""`lwr-dyn rank`."""

import json

import pytest


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


def left(lwr_dyn_command, *options):
    code, out, err = lwr_dyn_command("rank", "panda", "--log", "panda_salerno", *options, "--json")
    assert code == 0, err
    return {one["set"]: one["left"][0] for one in json.loads(out)["sets"] if one["set"] != "least squares"}


def test_all_sets_are_loaded_with_the_options_of_the_robot(lwr_dyn_command):
    """On the floor, where the log was taken, and as if the arm had carried a load."""
    floor = left(lwr_dyn_command, "--reading", "gaz", "--mount", "floor")
    assert floor == {"gaz": pytest.approx(0.393, rel=0.01)}
    loaded = left(lwr_dyn_command, "--sets", "gaz,panda:fer", "--tool", "mass=3")
    assert loaded.keys() == {"gaz", "panda:fer"}
    assert min(loaded.values()) > 1.5


def test_options_that_do_not_fit_are_one_line(lwr_dyn_command):
    for options, words in (
        (("--sets", "gaz", "--reading", "fer"), "reading: fer, and sets; allowed: the sets alone"),
        (("--tip", "hand"), "tip: given for panda; allowed: only with a .urdf"),
        (("--sets", "gaz", "--lock", "joint_9=0"), "joint_9"),
        (("--sets", "gaz", "--lock", "joint_7=0"), "joint"),
    ):
        code, out, err = lwr_dyn_command("rank", "panda", "--log", "panda_salerno", *options)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert words in err
