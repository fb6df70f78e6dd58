"""The table in Markdown has each run in its row and column, and says where there is none."""

from lwr_dyn.studies.compare.comparison import cross_table


def run(typed, plant, error, unstable=False, best=()):
    return {"typed": typed, "plant": plant, "tip_rms_mm": error, "unstable": unstable, "best": list(best)}


def test_each_run_stands_in_its_row_and_column():
    text = cross_table([
        run("a", "as modelled", 1.23456, best=["tip_rms_mm"]), run("b:xi=2", "as modelled", 12345.0, unstable=True),
        run("b:xi=2", "late", 0.000123456, best=["tip_max_mm"]),
    ])  # fmt: skip
    assert text.splitlines() == [
        "| plant | `a` | `b:xi=2` |", "| --- | --- | --- |",
        "| as modelled | **1.23** | 1.23e+04 ! |", "| late | none | 0.000123 |",
    ]  # fmt: skip
