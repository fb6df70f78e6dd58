"""The time an arm's page takes for its numbers: `python -m scripts.benchmarks.explorer_page [ROBOT]`, in Chromium.

Computed: g, B, C, torques, intervals and branches of the arm angle. Written: sliders and panels that are seen on a
screen of 1400 x 900. Goals for the LWR 4+: 0.5 ms a frame with the text, 0.2 computing after warm-up, the strip 1 ms,
the first frame 15 ms; page 0.9 MB, 0.25 zipped.
"""

import gzip
import statistics
import sys
import tempfile
from pathlib import Path

import lwr_dyn
from lwr_dyn.pages.explorer.page import write_explorer
from tests.headless import browser_window
from tests.pages.explorer.explored import opened

FRAMES = """const done = arguments[arguments.length - 1], e = lwrExplorer, { q } = e.state;
const numbers = [], all = [], strip = [];
const frame = (k) => {
  const at = Float64Array.from(q, (x, i) => x + 0.2 * Math.sin(0.05 * k + i)), state = { ...e.state, q: at };
  const t0 = performance.now();
  for (let m = 0; m < 10; m += 1) e.torques?.compute(state);
  for (let m = 0; m < 10; m += 1) e.strip?.compute(at);
  const t1 = performance.now();
  for (let m = 0; m < 10; m += 1) e.strip?.compute(at);
  const t2 = performance.now();
  e.setPose(at); // the page's own frame comes next, then this one's callback
  const t3 = performance.now();
  numbers.push((t1 - t0) / 10); strip.push((t2 - t1) / 10);
  requestAnimationFrame(() => {
    all.push(t3 - t2 + e.state.spent.at(-1));
    if (k < 200) frame(k + 1); else done([numbers, strip, all]);
  });
};
frame(0);"""


def main(robot: str) -> None:
    """Print the medians of 200 frames."""
    with tempfile.TemporaryDirectory() as folder, browser_window(Path(folder) / "profile") as browser:
        page = Path(folder) / "page.html"
        write_explorer(page, lwr_dyn.load(robot))
        data = page.read_bytes()
        print(f"{robot}: page {len(data) / 1e6:.3f} MB, zipped {len(gzip.compress(data, 9)) / 1e6:.3f} MB")
        screen = {"width": 1400, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        window = opened(browser, page.as_uri())
        window.set_script_timeout(120)
        first = window.execute_script(
            "lwrExplorer.state.spent.length || lwrExplorer.state.compute(); return lwrExplorer.state.spent[0]"
        )
        numbers, strip, everything = window.execute_async_script(FRAMES)
        print(f"first frame of the panels {first:.2f} ms")
        for name, times in (
            ("numbers", numbers),
            ("the strip alone", strip),
            ("numbers, sliders and text of what is seen", everything),
        ):
            early, late = statistics.median(times[:30]), statistics.median(times[100:])
            print(f"{name}: median of frames 1 to 30 {early:.3f} ms, of 101 to 200 {late:.3f} ms")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "lwr4plus")
