"""The file of a study, and a table of what it can vary."""

from pathlib import Path

from lwr_dyn.studies.sweep.study_template import study_template
from lwr_dyn.studies.sweep.vocabulary import METRICS, PATHS, PathRow


def study_text(root: Path) -> str:
    """The commented study that `lwr-dyn new study` writes."""
    return f"```toml\n{study_template('my_study.toml', 'my_study')}```"


def paths_text(root: Path) -> str:
    """A table of the paths."""
    lines = ["| path | what varies | unit | as modelled | usual |", "|---|---|---|---|---|"]
    for path, row in PATHS.items():
        modelled = "" if row.nominal is None else f"{row.nominal:g}"
        lines.append(f"| `{path}`{_more(row)} | {row.words} | {row.unit} | {modelled} | {row.usual} |")
    return "\n".join(lines)


def metrics_text(root: Path) -> str:
    """A table of the metrics."""
    lines = ["| metric | what it is | unit |", "|---|---|---|"]
    for name, row in METRICS.items():
        each = ", of each joint" if row.per_joint else ""
        lines.append(f"| `{name}` | {row.words}{each} | {row.unit} |")
    return "\n".join(lines)


def _more(row: PathRow) -> str:
    more = [".all", ".3"] if row.of else []
    more += [f"{more[-1] if more else ''}.z"] if row.axes else []
    return "".join(f", `{each}`" for each in more)
