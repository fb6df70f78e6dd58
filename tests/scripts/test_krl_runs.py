"""The study of runs on an invented repository: which runs count, and what stays of them."""

import tomllib

from scripts.studies.krl_runs import as_toml, chosen, motion_lines, table, tried

HOME = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0}\n"
SQUARE = (
    "DEF square( )\n$VEL.CP = 0.2\n" + HOME + "LIN_REL {X 10}\nlin_rel {Y 10}\nLIN_REL {X -10}\nLIN_REL {Y -10}\nEND\n"
)
FILES = {
    "ann+cell/square.src": SQUARE,
    "ann+cell/branch.src": SQUARE.replace("square", "branch").replace(
        "lin_rel {Y 10}", "IF $IN[1] THEN\nPTP_REL {A1 1}\nENDIF"
    ),
    "ann+cell/short.src": "DEF short( )\n" + HOME + "END\n",
    "ann+cell/far.src": "DEF far( )\n" + HOME + "PTP {X 9000,Y 0,Z 0,A 0,B 0,C 0}\nEND\n",
    "ann+cell/none.src": "DEF none( )\n; PTP\nEND\n",
}
ROW = {"name": "small", "machine": "", "cell": "cell.toml", "programs": ["ann+cell/*"]}


def test_a_run_counts_with_five_motions_and_without_an_error(tmp_path):
    for name, text in FILES.items():
        path = tmp_path / "programs" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="latin-1")
    (tmp_path / "cell.toml").write_text('robot = "kr30ha"\n[inputs]\nothers = false\n', encoding="utf-8")
    folder = tmp_path / "programs"
    row = {**ROW, "cell": str(tmp_path / "cell.toml")}
    found = {path.stem: row for path, row in chosen(folder, [row], "*")}
    assert set(found) == {"square", "branch", "short", "far"}
    assert motion_lines(folder / "ann+cell/square.src") == {3, 4, 5, 6, 7}
    runs = {x.program.split("/")[1]: x for x in (tried(folder, folder / f"ann+cell/{name}.src", row) for name in found)}
    assert {name: (x.counts, x.whole, x.reached, x.statements) for name, x in runs.items()} == {
        "square.src": (True, True, 5, 5),
        "branch.src": (False, False, 4, 5),
        "short.src": (False, False, 1, 1),
        "far.src": (False, False, 0, 2),
    }
    assert "reach" in runs["far.src"].fault
    assert "1 of 4 ran with 5 motions or more; 2 without a robot" in table(list(runs.values()), 2)
    (row,) = tomllib.loads(as_toml(list(runs.values())))["run"]
    assert (row["program"], row["motions"], row["reached"]) == ("ann+cell/square.src", 5, [5, 5])
