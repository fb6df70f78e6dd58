"""The gallery: runs made by the commands of `gallery.toml`, each replayed in a page of its own.

A page is made again when its card or the package has changed.
"""

import hashlib
import shutil
import subprocess
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from html import escape
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import lwr_dyn
from tests.docs.console import environment, ready

FOLDER = "gallery_pages"
Card = dict[str, Any]


def cards(root: Path) -> list[Card]:
    """The cards of `gallery.toml`."""
    found: list[Card] = tomllib.loads((root / "docs" / "gallery.toml").read_text(encoding="utf-8"))["card"]
    return found


def still(root: Path, name: str, dark: bool = False) -> Path:
    """The still of a card, taken by `scripts/site_stills.py`."""
    return root / "docs" / "_static" / "stills" / f"{name}{'_dark' if dark else ''}.webp"


def picture(name: str, title: str, root: Path, up: str = "") -> str:
    """HTML of a still that becomes the live page when it is clicked."""
    images = "".join(
        f'<img class="only-{scheme}" src="{up}_static/stills/{path.name}" alt="{escape(title)}" loading="lazy" '
        f'width="960" height="600">'
        for scheme, path in (("light", still(root, name)), ("dark", still(root, name, True)))
        if path.is_file()
    )
    title = escape(title)
    link = f'<a class="still" href="{up}{FOLDER}/{name}.html" data-title="{title}">'
    return f"<div>{link}{images}<span>▶ move it in 3D</span></a></div>"


def gallery_text(root: Path) -> str:
    """A section for each card: the still, what it shows, the commands that made it."""
    parts = []
    for card in cards(root):
        commands = "\n".join(f"$ {command}" for command in card["commands"])
        if "runs" in card:
            commands += f"\n$ lwr-dyn replay {' '.join(card['runs'])} --html {card['name']}.html"
        parts += [f"## {card['title']}", card["text"], picture(card["name"], card["title"], root)]
        parts += [f":::{{dropdown}} Commands\n```console\n{commands}\n```\n:::"]
    return "\n\n".join(parts)


def first_picture(root: Path) -> str:
    """The picture of the first page."""
    card = cards(root)[0]
    return f"{picture(card['name'], card['title'], root)}\n\n{card['text']} [More in the gallery](gallery.md)."


def fingerprint(root: Path) -> str:
    """Changes with the package and with what the cards read."""
    digest = hashlib.sha256()
    files = [p for folder in ("lwr_dyn", "scripts/examples") for p in (root / folder).rglob("*") if p.is_file()]
    for path in sorted([*files, root / "tests" / "dynamics" / "puma560.toml", Path(__file__)]):
        if "__pycache__" not in path.parts:
            digest.update(path.read_bytes())
    return digest.hexdigest()


def make_runs(card: Card, root: Path, folder: Path) -> None:
    """Run the commands of a card in a folder; raises `RuntimeError` with what they printed when one fails."""
    for name in ("scripts", "tests"):
        (folder / name).symlink_to(root / name)
    with tempfile.TemporaryDirectory() as programs:
        for command in card["commands"]:
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=folder,
                env=environment(Path(programs), command),
                capture_output=True,
                text=True,
            )
            if done.returncode:
                raise RuntimeError(f"gallery, {card['name']}: {command}\n{done.stdout}{done.stderr}")


def make_pages(app: Sphinx) -> None:
    """Make the pages that are missing or old, two at a time, and put all of them beside the site's pages."""
    if app.builder.format != "html":
        return
    root, kept = Path(app.srcdir).parent, Path(app.doctreedir) / FOLDER
    target = Path(app.outdir) / FOLDER
    target.mkdir(parents=True, exist_ok=True)
    kept.mkdir(parents=True, exist_ok=True)
    base = fingerprint(root)
    wanted = {
        card["name"]: kept / f"{card['name']}-{hashlib.sha256(f'{base}{card}'.encode()).hexdigest()[:16]}.html"
        for card in cards(root)
    }
    missing = [card for card in cards(root) if not wanted[card["name"]].is_file()]
    if missing:
        ready()  # once: two threads would start two
    with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(2) as pool:
        folders = [Path(scratch) / card["name"] for card in missing]
        for folder in folders:
            folder.mkdir()
        list(pool.map(make_runs, missing, [root] * len(missing), folders))
        for card, folder in zip(missing, folders, strict=True):
            write_page(card, folder, wanted[card["name"]])
    for old in set(kept.glob("*.html")) - set(wanted.values()):
        old.unlink()
    for name, path in wanted.items():
        shutil.copyfile(path, target / f"{name}.html")


def write_page(card: Card, folder: Path, path: Path) -> None:
    """The page that replays a card's runs, or that its commands have written."""
    if "page" in card:
        shutil.copyfile(folder / card["page"], path)
        return
    runs = [lwr_dyn.Run.load(folder / name) for name in card["runs"]]
    lwr_dyn.replay(runs, path, title=card["title"])


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the step."""
    app.connect("builder-inited", make_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
