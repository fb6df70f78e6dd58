"""The built site: made once a session, whichever worker asks first; its pages and links."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

from tests.docs.console import READY, ready

ROOT = Path(__file__).resolve().parents[2]


def build(folder: Path) -> None:
    """Build the site into a folder as a release does; a warning is an error."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", str(ROOT / "docs"), str(folder)]
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | {"OMP_NUM_THREADS": "1", READY: ready()}, text=True, timeout=900,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-8000:]


def built_once(base: Path) -> Path:
    """The site in a folder that all workers of the session share; `LWR_DYN_SITE` names one that is there."""
    if "LWR_DYN_SITE" in os.environ:
        return Path(os.environ["LWR_DYN_SITE"])
    folder, done = base / "site", base / "site.done"
    with (base / "site.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            done.touch()  # a build that failed is not tried again
            build(folder)
    assert (folder / "index.html").is_file(), "the site could not be built; the first test that asked says why"
    return folder


class Page(HTMLParser):
    """What a page links to, and the anchors it has."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep ids, and all addresses."""
        for name, value in attrs:
            if name == "id" and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def pages(site: Path) -> list[Path]:
    """The pages of the site itself, without the replays and reports that it shows."""
    others = {site / "gallery_pages", site / "reports"}
    return sorted(path for path in site.rglob("*.html") if not others & set(path.parents))


def broken_links(site: Path) -> Iterator[str]:
    """Relative links of all pages that lead to no file, or to no anchor in it."""
    read = {path.resolve(): Page(path) for path in pages(site)}
    for path, page in read.items():
        for link in page.links:
            if "://" in link or link.startswith(("data:", "mailto:")):
                continue
            place, _, anchor = link.partition("#")
            target = (path.parent / unquote(place.split("?")[0])).resolve() if place else path
            if not target.is_file():
                yield f"{path.name}: {link}: no such file"
            elif anchor and target in read and unquote(anchor) not in read[target].anchors:
                yield f"{path.name}: {link}: no such anchor"
