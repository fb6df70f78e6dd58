"""`lwr-dyn fmu`: writes the file, says what is in it, refuses in one line."""

import zipfile

import pytest

from lwr_dyn.cli.main import main


def run(*words):
    with pytest.raises(SystemExit) as end:
        main(["fmu", *words])
    return end.value.code


def test_a_plant_is_written(tmp_path, capsys):
    path = tmp_path / "x.fmu"
    assert not run("lwr4plus", "--out", str(path), "--fmi", "2")
    assert f"wrote {path}: lwr4plus_plant, FMI 2.0, sources only" in capsys.readouterr().out
    assert "sources/fmu.c" in zipfile.ZipFile(path).namelist()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--out", "x.zip"), "--out: 'x.zip'; allowed: a path that ends in .fmu"),
        (("--out", "x.fmu", "--rate", "500"), "--rate: 500.0; allowed: only with --law"),
        (("--out", "x.fmu", "--law", "pi"), "no control law that can be written named 'pi'"),
        (("--out", "x.fmu", "--fmi", "1"), "'1' is not one of '2', '3'"),
    ],
)
def test_bad_input_is_one_line(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert run("lwr4plus", *words) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
