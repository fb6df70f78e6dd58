"""`lwr-dyn rank`: what is typed reaches the ranking; it ranks, writes the page, and says what does not fit."""

from types import SimpleNamespace

import pytest

from lwr_dyn.foundation.document import Document

LOG = ("rank", "panda", "--log", "panda_salerno")


def test_what_is_typed_reaches_the_ranking(asked, printed):
    calls = asked("lwr_dyn.cli.rank.rank", SimpleNamespace(document=Document("", "ranked", ())))
    options = ("--sets", "gaz, fer", "--free", "load,rotor", "--test", "b.csv", "--logs-in", "there", "--cutoff", "7",
               "--columns", "q=pos_*", "--units", "q=deg", "--mount", "wall")  # fmt: skip
    for more, sets, free, rest in (
        (options, ("gaz", "fer"), ("load", "rotor"), ("b.csv", "there", 7.0, {"q": "deg"}, ("wall",))),
        ((), (), (), (None, None, None, {}, None)),
    ):
        assert printed(*LOG, *more) == "ranked\n"
        arguments, given = calls.pop()
        found = (*(given[name] for name in ("test", "folder", "cutoff", "units")), given["loading"]["mount"])
        assert (arguments, given["free"], found) == (("panda", "panda_salerno", sets), free, rest)
        assert ("pos_*" in repr(given["columns"])) == bool(more)


def test_it_ranks_and_writes_the_page(printed, recorded, tmp_path):
    page = tmp_path / "panda.html"
    out = printed(*LOG, "--sets", "gaz,fer", "--html", str(page))
    assert "gaz leaves 0.393" in out
    assert out.endswith(f"wrote {page}\n")
    assert "torques against measurement" in page.read_text()
    record = recorded(*LOG, "--sets", "gaz", "--free", "load")
    assert record["sets"][0]["set"] == "gaz"
    assert record["train_rows"] > record["test_rows"]


def test_all_sets_are_loaded_with_the_options_of_the_robot(recorded):
    """On the floor, where the log was taken, and as if the arm had carried a load."""

    def left(*options):
        return {x["set"]: x["left"][0] for x in recorded(*LOG, *options)["sets"] if x["set"] != "least squares"}

    assert left("--reading", "gaz", "--mount", "floor") == {"gaz": pytest.approx(0.393, rel=0.01)}
    loaded = left("--sets", "gaz,panda:fer", "--tool", "mass=3")
    assert loaded.keys() == {"gaz", "panda:fer"}
    assert min(loaded.values()) > 1.5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("ur10e", "--log", "ur10e_30s_target"), "computed, not measured"),
        (("ur10e", "--log", "ur10e_30s"), "github.com/shamilmamedov"),
        ((*LOG[1:], "--sets", "gaz", "--reading", "fer"), "reading: fer, and sets; allowed: the sets alone"),
        ((*LOG[1:], "--tip", "hand"), "tip: given for panda; allowed: only with a .urdf"),
        ((*LOG[1:], "--sets", "gaz", "--lock", "joint_9=0"), "joint_9"),
        ((*LOG[1:], "--sets", "gaz", "--lock", "joint_7=0"), "joint"),
        ((*LOG[1:], "--html", "x.txt"), "x.txt: ends in '.txt'; allowed: a path in .html"),
    ],
)
def test_what_does_not_fit_is_one_line(refused, arguments, words):
    assert words in refused("rank", *arguments)
