"""`lwr-dyn lint`: exit codes, one line for bad input, JSON."""

import json

import pytest

from lwr_dyn.cli.main import main

GAINS = "Joint,K_P,K_D\n1,7310,292.4\n2,7270,290.8\n3,1225.7,49.03\n4,13.5,4.4\n5,0.5392,0.1756\n"


def run(*arguments):
    with pytest.raises(SystemExit) as stop:
        main(["lint", *arguments])
    return stop.value.code


def test_a_finding_is_printed_with_its_place(tmp_path, capsys):
    (tmp_path / "gains.csv").write_text(GAINS)
    assert run(str(tmp_path / "gains.csv")) == 1
    out = capsys.readouterr().out
    assert "gains.csv:gains, row 4, K_D: error swapped: " in out
    assert out.endswith("1 found\n")


def test_json(tmp_path, capsys):
    (tmp_path / "gains.csv").write_text(GAINS)
    assert run(str(tmp_path / "gains.csv"), "--json") == 1
    record = json.loads(capsys.readouterr().out)
    assert record["holds"] is False
    assert record["findings"][0]["rule"] == "swapped"


def test_a_clean_robot(capsys):
    assert run("wam7") == 0
    assert capsys.readouterr().out.endswith(" numbers looked at: 0 found\n")


def test_all_that_is_printed_of_a_robot(capsys):
    assert run("lwr4plus") == 1
    out = capsys.readouterr().out
    for rule in ("power-of-ten", "rows-shifted", "copied", "column-order", "swapped", "unit"):
        assert f" {rule}: " in out, rule


@pytest.mark.parametrize("name", ["nobody", "nofile.csv", "nofile.toml", "/etc"])
def test_bad_names(name, capsys):
    assert run(name) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert not captured.out


def test_bytes_that_are_no_text(tmp_path, capsys):
    (tmp_path / "x.csv").write_bytes(b"\xff\xfe\x00")
    assert run(str(tmp_path / "x.csv")) == 2
    assert "not UTF-8" in capsys.readouterr().err
