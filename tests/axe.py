"""Accessibility of a page in a browser: axe-core's rules, and the contrast of text in SVG, which axe leaves open.

A test opens its page and asks on its screens:

    with seen(browser, width, dark):
        assert violations(browser) == []
        assert faint_texts(browser) == []
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path

SCREENS = [(1600, False), (1600, True), (420, False), (420, True)]
"""(width [px], dark): what every kind of page is judged on."""
EACH_ONCE = [SCREENS[0], SCREENS[3]]
"""Each width and each scheme once: for more pages of a kind, where colours do not depend on the width."""
TWO_FRAMES = "requestAnimationFrame(() => requestAnimationFrame(() => arguments[0]()))"
LOOKS = """const drawn = new Map(), alike = new Map();
const ground = (node) => {
  if (node === null) return "";
  if (!drawn.has(node)) {
    const style = getComputedStyle(node), all = [style.backgroundColor, style.backgroundImage, style.opacity];
    drawn.set(node, `${all} ${ground(node.parentElement)}`);
  }
  return drawn.get(node);
};
for (const node of document.body.querySelectorAll("*")) {
  node.removeAttribute("data-look");
  if (![...node.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim())) continue;
  const style = getComputedStyle(node), box = node.getBoundingClientRect();
  if (!node.checkVisibility({checkOpacity: true, checkVisibilityCSS: true})) continue;
  if (style.clip !== "auto" || style.clipPath !== "none" || box.width < 2 || box.height < 2) continue;
  const off = node.closest(":disabled, [aria-disabled=true]") !== null;
  const look = [style.color, style.fontSize, style.fontWeight, style.textShadow, off, ground(node)].join();
  alike.set(look, [...(alike.get(look) ?? []), node]);
}
for (const nodes of alike.values())
  for (const node of [...nodes.slice(0, FEW), ...nodes.slice(-FEW)]) node.setAttribute("data-look", "");"""
"""Marks text: some of each look, that is of its own colour and size and all grounds below it."""
FEW = 4
"""Texts of one look that are judged, at the begin and at the end of a page."""
RUN = """const done = arguments[arguments.length - 1];
const whole = {rules: {"color-contrast": {enabled: false}}}, colours = {runOnly: ["color-contrast"]};
const all = {resultTypes: ["violations"], iframes: false};
axe.run(document, {...all, ...whole}).then((found) =>
  axe.run({include: [["[data-look]"]]}, {...all, ...colours}).then((faint) =>
  done([...found.violations, ...faint.violations].flatMap((rule) => rule.nodes.map((node) => {
    const why = node.failureSummary.split("\\n").slice(1).join(" ").trim();
    return `${rule.id} (${rule.impact}): ${node.target.join(" ")}: ${why}`;
  }))))).catch((fault) => done([`axe: ${fault}`]));"""
FAINT = """const parse = (text) => {
  const [r, g, b, a = 1] = (text.match(/[\\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
  return text.startsWith("color(srgb") ? [255 * r, 255 * g, 255 * b, a] : [r, g, b, a];
};
const over = (top, below) => [0, 1, 2].map((i) => top[3] * top[i] + (1 - top[3]) * below[i]);
const light = (rgb) => rgb.map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
  .reduce((sum, v, i) => sum + [0.2126, 0.7152, 0.0722][i] * v, 0);
const behind = (node) => {
  if (node === null) return parse(getComputedStyle(document.documentElement).colorScheme.includes("dark") &&
    matchMedia("(prefers-color-scheme: dark)").matches ? "rgb(18, 18, 18)" : "rgb(255, 255, 255)").slice(0, 3);
  const own = parse(getComputedStyle(node).backgroundColor);
  return own[3] >= 1 ? own.slice(0, 3) : over(own, behind(node.parentElement));
};
return [...document.querySelectorAll("svg text, svg tspan")].flatMap((text) => {
  const own = [...text.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim());
  if (!own || !text.checkVisibility({checkOpacity: true, checkVisibilityCSS: true})) return [];
  const style = getComputedStyle(text), fill = parse(style.fill), ground = behind(text.closest("svg"));
  for (let node = text; node; node = node.parentElement) fill[3] *= Number(getComputedStyle(node).opacity);
  fill[3] *= Number(style.fillOpacity);
  const [low, high] = [light(over(fill, ground)), light(ground)].sort((a, b) => a - b);
  const ratio = (high + 0.05) / (low + 0.05), name = text.textContent.trim();
  return ratio < 4.5 ? [`${name}: ${ratio.toFixed(2)} (${style.fill} on ${ground.map(Math.round)})`] : [];
});"""


@cache
def axe_script() -> str:
    """axe-core as it stands in the package that brings it; the package itself, and so playwright, is not imported."""
    spec = find_spec("axe_playwright_python")
    assert spec is not None, "axe-playwright-python is not installed (extra test)"
    assert spec.origin is not None
    return (Path(spec.origin).parent / "axe.min.js").read_text(encoding="utf-8")


@contextmanager
def seen(browser, width: int, dark: bool = False, height: int = 1000) -> Iterator:
    """The page on a screen of this width [px], narrow ones as phones, under the light or the dark scheme."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
    scheme = {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", scheme)
    browser.execute_async_script(TWO_FRAMES)
    try:
        yield browser
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
        browser.execute_async_script(TWO_FRAMES)


def violations(browser) -> list[str]:
    """What axe-core finds against any of its rules (WCAG 2.0 to 2.2 A and AA, best practice) on the page.

    Contrast, which takes nearly all of its time on a long page, is asked of `FEW` first and last texts of each look.
    """
    if not browser.execute_script("return !!window.axe"):
        browser.execute_script(axe_script() + "\nwindow.axe = axe;")
    browser.execute_script(f"const FEW = {FEW};\n{LOOKS}")
    return browser.execute_async_script(RUN)


def faint_texts(browser) -> list[str]:
    """Visible text in SVG whose contrast to what its SVG stands on is below 4.5."""
    return browser.execute_script(FAINT)


def sideways(browser) -> int:
    """How far the page can be scrolled sideways [px]."""
    return browser.execute_script("return document.documentElement.scrollWidth - document.documentElement.clientWidth")
