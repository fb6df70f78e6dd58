"""`lwr-dyn new study`: a commented study to start from."""

from importlib.resources import files
from textwrap import wrap

import click

from lwr_dyn.cli.new import new_file
from lwr_dyn.foundation.files import write_file
from lwr_dyn.studies.sweep.study.parameter_paths import OPTION, PATHS


def study_template(file: str, name: str) -> str:
    """The text of a commented study; it runs as it stands.

    >>> 'path = "payload.mass"' in study_template("x.toml", "x")
    True
    """
    text = (files("lwr_dyn.studies.sweep.study") / "new_study.toml").read_text(encoding="utf-8")
    paths = ", ".join(path for path in PATHS if OPTION not in path)
    listed = "\n#   ".join(wrap(paths, 100))
    return text.replace("@@file@@", file).replace("@@name@@", name).replace("@@paths@@", f"\n#   {listed}")


@click.command("study")
@click.argument("file")
def command(file: str) -> None:
    """Write a study: which loops, what varies, how many runs; `lwr-dyn sweep` runs it."""
    path = new_file(file, ".toml")
    write_file(path, study_template(file, path.stem))
    click.echo(f"wrote {file}; next: edit it, then  lwr-dyn sweep {file} --out {path.stem}")
