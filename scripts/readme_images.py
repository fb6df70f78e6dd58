"""Take the pictures of the README from the pages of the current build, or check that they are fresh.

python scripts/readme_images.py                     run `reproduce lwr4plus`, write the explorer, take the pictures
python scripts/readme_images.py --folder out/lwr4plus   of the reproduction that is there
python scripts/readme_images.py --check             take them to compare; exit 1 when one is old

A picture is fresh when its page shows the same words as then (kept in the PNG) and looks the same from afar. Needs the
extra `test`, chromium and chromedriver.
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from lwr_dyn import load
from lwr_dyn.pages.explorer.page import write_explorer
from lwr_dyn.reproduction.reproduce import reproduce

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # the browser is that of `tests`
IMAGES = ROOT / ".images"
WORDS = "words"
"""The key of the PNG's text under which the words of the page are kept."""
SMALL = (36, 30)
"""Pixels (columns, rows) of the pictures that are compared: letters and edges are gone, shapes and colours stay."""
DIFFERENT = 25.0
"""Largest difference of a pixel of the small pictures [of 255]. The PNG's palette makes 9, a replay 0.1 s later 34."""

VISIBLE_WORDS = """
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), words = [];
const seen = (r) => r.width > 0 && r.height > 0 && r.bottom <= innerHeight && r.top >= 0 && r.right <= innerWidth;
for (let node = walker.nextNode(); node; node = walker.nextNode()) {
  const range = document.createRange(), hidden = node.parentElement.closest("script, style, option, svg");
  range.selectNodeContents(node);
  if (!hidden && node.data.trim() && seen(range.getBoundingClientRect()) && node.parentElement.checkVisibility())
    words.push(node.data.trim().replace(/\\s+/g, " "));
}
return words.join("\\n");
"""
"""JavaScript: the words that stand whole in the window, in the order of the page; not those of drawings."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A page at a size, in a state of its own."""

    page: str
    ready: str  # JavaScript that is true once the page stands
    state: str  # JavaScript that brings the page into the state that is shown
    width: int
    height: int


Q = [0.4, 0.6, -0.3, -1.2, 0.2, 0.9, 0]
"""Positions of the explorer's arm [rad]."""
WRITTEN = """
const write = (field, value) => { field.value = value; field.dispatchEvent(new Event("change")); };
document.querySelectorAll(".rate[data-of=dq]").forEach((field, i) => write(field, [1, -1.2, 1, 1.5, 0, 1, 0][i]));
document.querySelectorAll(".rate[data-of=ddq]").forEach((field, i) => write(field, [2, -4, 3, 6, 1, -4, 2][i]));
write(document.querySelector("[aria-label='payload, kg']"), 3);
"""
"""JavaScript: speeds, accelerations and a payload, as written into the fields of the page."""

PICTURES = {
    "replay.png": Picture(
        "replay.html",
        "return !!(window.lwrReplay && lwrReplay.ready)",
        "lwrReplay.stage.frameView(); lwrReplay.setTime(13.2)",
        1440,
        757,
    ),
    "explorer.png": Picture(
        "explorer.html",
        "return !!(window.lwrExplorer && lwrExplorer.torques)",
        WRITTEN,
        1440,
        840,
    ),
}


def take(browser: Any, picture: Picture, folder: Path) -> tuple[Image.Image, str]:
    """A page of a folder as it looks, and its words."""
    from selenium.webdriver.support.ui import WebDriverWait

    size = {"width": picture.width, "height": picture.height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_cdp_cmd("Emulation.setScrollbarsHidden", {"hidden": True})
    try:
        browser.get((folder / picture.page).resolve().as_uri())
        WebDriverWait(browser, 60).until(lambda window: window.execute_script(picture.ready))
        browser.execute_async_script("document.fonts.ready.then(() => arguments[0]())")  # the bar has its height
        browser.execute_script(picture.state)
        drawn = "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(arguments[0], 500)))"
        browser.execute_async_script(drawn)
        return _still(browser), browser.execute_script(VISIBLE_WORDS)
    finally:
        browser.execute_cdp_cmd("Emulation.setScrollbarsHidden", {"hidden": False})
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def _still(browser: Any) -> Image.Image:
    """The window once it stands still: a busy machine draws the 3D view late."""
    before, still = None, 0
    for _ in range(40):
        image = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
        still = still + 1 if before is not None and image.tobytes() == before.tobytes() else 0
        if still == 2:
            return image
        before = image
        browser.execute_async_script("requestAnimationFrame(() => setTimeout(arguments[0], 300))")
    raise RuntimeError("the page does not stand still")


def save(path: Path, image: Image.Image, words: str) -> None:
    """Write a picture with the words of its page."""
    text = PngInfo()
    text.add_itxt(WORDS, words)
    image.quantize(256, kmeans=2, dither=Image.Dither.NONE).save(path, pnginfo=text, optimize=True)


def faults(path: Path, image: Image.Image, words: str) -> list[str]:
    """Why a picture is not what its page shows now; empty for a fresh one."""
    if not path.is_file():
        return [f"{path.name}: missing"]
    with Image.open(path) as kept:
        kept.load()
        before = str(getattr(kept, "text", {}).get(WORDS, ""))
        difference = np.abs(_small(kept) - _small(image)).max() if kept.size == image.size else np.inf
    gone = [line for line in before.splitlines() if line not in words.splitlines()]
    new = [line for line in words.splitlines() if line not in before.splitlines()]
    found = [f"{path.name}: shows {line!r}, the page does not" for line in gone]
    found += [f"{path.name}: lacks {line!r} of the page" for line in new]
    if difference > DIFFERENT:
        found.append(f"{path.name}: looks different, by {difference:.0f} of 255 (at most {DIFFERENT:g})")
    return found


def _small(image: Image.Image) -> np.ndarray:
    return np.asarray(image.convert("RGB").resize(SMALL, Image.Resampling.BOX), dtype=float)


def pictures(browser: Any, folder: Path) -> Iterator[tuple[Path, Image.Image, str]]:
    """Where each picture of the README belongs, how its page looks, and the words of the page.

    The folder is that of `reproduce lwr4plus`; the explorer's page is written for the picture.
    """
    with tempfile.TemporaryDirectory() as scratch:
        write_explorer(Path(scratch) / "explorer.html", load("lwr4plus"), Q)
        for name, picture in PICTURES.items():
            there = folder if (folder / picture.page).is_file() else Path(scratch)
            yield (IMAGES / name, *take(browser, picture, there))


def main(arguments: list[str] | None = None) -> int:
    from tests.headless import browser_window

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a picture is old")
    parser.add_argument("--folder", type=Path, help="what `reproduce lwr4plus` wrote (default: run it)")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch) / "lwr4plus"
        if options.folder is None:
            reproduce("lwr4plus", folder)
        with browser_window(Path(scratch) / "profile") as browser:
            taken = list(pictures(browser, folder))
    if options.check:
        old = [line for each in taken for line in faults(*each)]
        print("\n".join(old) or f"fresh: {len(taken)} pictures")
        return 1 if old else 0
    for each in taken:
        save(*each)
        print(f"wrote {each[0].relative_to(ROOT)}, {each[0].stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
