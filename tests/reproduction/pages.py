"""What must hold for the report page of every paper: nothing is lost on it, it is short, and everyone can read it."""

import json
import re
from collections import Counter
from html import unescape

from tests.axe import EACH_ONCE, faint_texts, seen, sideways, violations
from tests.pages.replay.driven import opened

LARGEST_PAGE = 2_000_000
"""Bytes of a report at most."""
FIRST_SCREEN = 1000
"""[px] The answer and all verdicts stand above this at a width of 1600 px."""


def lost(folder, page="report.html"):
    """Numbers, errata, proofs, checks and figures of a folder that its page does not show; empty when all are there."""
    text = (folder / page).read_text(encoding="utf-8")
    record = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    printed = Counter(map(unescape, re.findall(r'<button class="n"[^>]*>([^<]*)</button>', text)))
    wanted = Counter(number["printed"] for number in record["numbers"])
    out = [f"number {one}" for one in wanted - printed]
    plain = unescape(re.sub(r"<[^>]*>", "\n", text))
    out += [f"place {number['cell']}" for number in record["numbers"] if f"({number['cell']})" not in plain]
    for erratum in record["errata"]:
        parts = [erratum[key] for key in ("id", "printed", "read_as", "why")]
        proof = erratum["proof"] or {"statement": "", "numbers": {}}
        parts += [proof["statement"], *(f"{name}: " for name in proof["numbers"])]
        out += [f"erratum {erratum['id']}: {part}" for part in parts if part not in plain]
    for reading, checks in record["checks"].items():
        out += [f"check {name} ({reading})" for name in checks if f"{name} ({reading})" not in plain]
    figures = (
        json.loads((folder / "figures.json").read_text()) if (folder / "figures.json").is_file() else {"figures": {}}
    )
    ids = [figure["id"] for drawn in figures["figures"].values() for figure in drawn if figure["id"]]
    return out + [f"figure {one}" for one in ids if f'data-plot="{one}"' not in text]


def heights(browser):
    """Height of the page, with all that is far away laid out too, and where its summary ends [px]."""
    return browser.execute_script(
        """const all = document.createElement("style");
        all.textContent = ".box { content-visibility: visible !important }";
        document.head.append(all);
        const lead = document.querySelector(".lead").getBoundingClientRect().bottom + window.scrollY;
        const found = [document.documentElement.scrollHeight, lead];
        all.remove();
        return found"""
    )


def faults(browser, path, wide, narrow):
    """What is wrong with a page: higher than `wide` or `narrow` [px] at 1600 and 420 px, too large, or hard to read."""
    out = []
    if path.stat().st_size > LARGEST_PAGE:
        out.append(f"{path.stat().st_size} bytes")
    opened(browser, path)
    for width, dark in EACH_ONCE:  # all four: report/test_page_reading.py
        with seen(browser, width, dark):
            high, summary = heights(browser)
            if high > (wide if width > 600 else narrow):
                out.append(f"{high} px high at {width}")
            if width > 600 and summary > FIRST_SCREEN:
                out.append(f"summary ends at {summary} px")
            found = [*violations(browser), *faint_texts(browser), *([f"sideways {width}"] if sideways(browser) else [])]
            out += [f"{width} {'dark' if dark else 'light'}: {one}" for one in found]
    return out
