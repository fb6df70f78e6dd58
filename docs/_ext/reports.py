"""The reports of the papers: linked when `lwr-dyn reproduce all` has written them to `out/`."""

import shutil
from pathlib import Path

from sphinx.application import Sphinx

from lwr_dyn.arms.papers.catalog import open_paper, studied

FOLDER = "reports"


def report(root: Path, robot: str) -> Path:
    """Where the report of a robot's paper is written."""
    return root / "out" / robot / "report.html"


def reports_text(root: Path) -> str:
    """A table of the papers with links to the reports that are there."""
    lines = ["| robot | source | report |", "|---|---|---|"]
    for robot in studied():
        title = open_paper(robot).title
        link = f"`lwr-dyn reproduce {robot}`"
        if report(root, robot).is_file():
            link = f'<a href="{FOLDER}/{robot}.html">report</a>'
        lines.append(f"| `{robot}` | {title} | {link} |")
    return "\n".join(lines)


def copy_reports(app: Sphinx, error: Exception | None) -> None:
    """Put the reports beside the pages."""
    if error is None and app.builder.format == "html":
        for robot in studied():
            source = report(Path(app.srcdir).parent, robot)
            if source.is_file():
                target = Path(app.outdir) / FOLDER / f"{robot}.html"
                target.parent.mkdir(exist_ok=True)
                shutil.copyfile(source, target)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the step."""
    app.connect("build-finished", copy_reports)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
