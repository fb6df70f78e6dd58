"""Take the stills of the site's gallery from its pages: python scripts/site_stills.py docs/_build

Build the site first. Needs the extra `test`, chromium and chromedriver.
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "docs" / "_ext")]
SIZE = (960, 600)
SHARE = 0.62
"""The part of the run that is over on the still."""
HIDDEN = "#side, #bar, footer, aside, header { display: none !important } #stage { inset: 0 !important; \
position: fixed !important; width: 100vw !important; height: 100vh !important }"


def take(browser: Any, page: Path, dark: bool) -> Image.Image:
    """The 3D scene of a replay, without its panels."""
    from tests.axe import seen
    from tests.headless import opened

    with seen(browser, SIZE[0], dark, SIZE[1]):
        opened(browser, page.resolve().as_uri())
        hide = "const s = document.createElement('style'); s.textContent = arguments[0]; document.head.append(s);"
        browser.execute_script(hide + "dispatchEvent(new Event('resize'));", HIDDEN)
        browser.execute_script("lwrReplay.setTime(arguments[0] * lwrReplay.duration)", SHARE)
        drawn = "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(arguments[0], 700)))"
        browser.execute_async_script(drawn)
        return Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")


def main(arguments: list[str] | None = None) -> None:
    from gallery import FOLDER, cards, still

    from tests.headless import browser_window

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("site", type=Path, help="the folder of the built site")
    site = parser.parse_args(arguments).site
    with tempfile.TemporaryDirectory() as profile, browser_window(Path(profile)) as browser:
        for card in cards(ROOT):
            for dark in (False, True):
                path = still(ROOT, card["name"], dark)
                path.parent.mkdir(exist_ok=True)
                take(browser, site / FOLDER / f"{card['name']}.html", dark).save(path, quality=72, method=6)
                print(f"{path.relative_to(ROOT)} {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
