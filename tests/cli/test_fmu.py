"""`lwr-dyn fmu`: what is typed reaches the file, which is written and named; bad input is one line."""

import zipfile
from types import SimpleNamespace

import pytest

MADE = SimpleNamespace(name="made", archive=lambda binary: b"with" if binary else b"without")


def test_a_plant_is_written(printed, tmp_path):
    path = tmp_path / "x.fmu"
    out = printed("fmu", "lwr4plus", "--out", str(path), "--fmi", "2")
    assert f"wrote {path}: lwr4plus_plant, FMI 2.0, sources only" in out
    assert "sources/fmu.c" in zipfile.ZipFile(path).namelist()


@pytest.mark.parametrize(
    ("options", "made", "asked_for", "held", "said"),
    [
        ((), "plant", ("3",), b"without", "made, FMI 3.0, sources only"),
        (("--law", "pid"), "controller", ("pid", "3", 1000.0), b"without", "made, FMI 3.0, sources only"),
        (("--law", "pid:ki=2", "--rate", "500", "--fmi", "2", "--binary"), "controller", ("pid:ki=2", "2", 500.0),
         b"with", "made, FMI 2.0, with a binary"),
    ],
)  # fmt: skip
def test_what_is_typed_reaches_the_file(asked, printed, folder, options, made, asked_for, held, said):
    calls = {name: asked(f"lwr_dyn.codegen.emit.fmu.{name}_fmu", MADE) for name in ("plant", "controller")}
    assert printed("fmu", "lwr4plus", "--out", "x.fmu", *options) == f"wrote x.fmu: {said}\n"
    (((arm, *more), _),) = calls[made]
    assert (arm.name, tuple(more), (folder / "x.fmu").read_bytes()) == ("lwr4plus", asked_for, held)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--out", "x.zip"), "--out: 'x.zip'; allowed: a path that ends in .fmu"),
        (("--out", "x.fmu", "--rate", "500"), "--rate: 500.0; allowed: only with --law"),
        (("--out", "x.fmu", "--law", "pi"), "no control law that can be written named 'pi'"),
        (("--out", "x.fmu", "--fmi", "1"), "'1' is not one of '2', '3'"),
        (("--out", "none/x.fmu"), "none/x.fmu: no directory none"),
    ],
)
def test_bad_input_is_one_line(refused, folder, words, said):
    assert said in refused("fmu", "lwr4plus", *words)
    assert not list(folder.iterdir())
