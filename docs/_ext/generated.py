"""Parts of pages that are made from the program: a line `<!-- generated: NAME -->` is replaced while a page is read.

Also: `python file=x.py` blocks get the file's name as a caption, and the index of a section gets the table of contents
that its links make.
"""

import re
from pathlib import Path

from command_pages import commands_text
from error_table import errors_text
from front_door import front_door_text
from gallery import first_picture, gallery_text
from reports import reports_text
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from study_parts import metrics_text, paths_text, study_text

from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.cli.new import paper_template

PLACE = re.compile(r"^<!-- generated: ([\w-]+) -->$", re.MULTILINE)
FILE_BLOCK = re.compile(r"^(?P<indent> *)```(?P<language>\w+) file=(?P<name>\S+)$", re.MULTILINE)
NO_RUN = re.compile(r"^( *```\w+) no-run .*$", re.MULTILINE)
LINK = re.compile(r"\]\(([\w/.]+)\.md[)#]")


def template_text(root: Path) -> str:
    """The commented data file that `lwr-dyn new arm` writes."""
    return f"```toml\n{template('my_arm.toml', 'my_arm', 'RR', 'modified')}\n```"


def paper_text(root: Path) -> str:
    """What `lwr-dyn new paper` writes below the data file of the arm."""
    arm = ("my_paper.toml", "my_paper", "RR", "modified")
    return f"```toml\n{paper_template(*arm).removeprefix(template(*arm)).lstrip()}```"


PARTS = {
    "commands": commands_text,
    "front-door": front_door_text,
    "errors": errors_text,
    "first-picture": first_picture,
    "gallery": gallery_text,
    "metrics": metrics_text,
    "paper": paper_text,
    "paths": paths_text,
    "reports": reports_text,
    "study": study_text,
    "template": template_text,
}
"""Name -> function of the project's root that gives Markdown."""


def contents_of(text: str, folder: Path) -> str:
    """A hidden table of contents of the pages that an index links to, in its order, and then of the others."""
    linked = [name for name in LINK.findall(text) if (folder / f"{name}.md").is_file()]
    others = sorted(path.stem for path in folder.glob("*.md") if path.stem != "index")
    names = list(dict.fromkeys([*linked, *others]))
    return "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"


def expand(app: Sphinx, docname: str, content: list[str]) -> None:
    """Fill the places of a page."""
    root = Path(app.srcdir).parent
    text = PLACE.sub(lambda found: PARTS[found[1]](root), content[0])
    text = FILE_BLOCK.sub(r"\g<indent>```{code-block} \g<language>\n\g<indent>:caption: \g<name>\n", text)
    text = NO_RUN.sub(r"\1", text)
    if docname.endswith("/index") and "{toctree}" not in text:
        text += contents_of(text, Path(app.srcdir) / Path(docname).parent)
    content[0] = text


def outdated(app: Sphinx, env: BuildEnvironment, added: set[str], changed: set[str], removed: set[str]) -> list[str]:
    """Pages with generated parts are read at each build: the program may have changed."""
    return [name for name in env.found_docs if PLACE.search(Path(env.doc2path(name)).read_text(encoding="utf-8"))]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the step."""
    app.connect("source-read", expand)
    app.connect("env-get-outdated", outdated)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
