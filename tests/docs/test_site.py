"""The site builds without a warning, asks no network, and is read by everyone."""

import re
import tomllib

import pytest

import lwr_dyn
from lwr_dyn.cli.main import COMMANDS
from tests.axe import EACH_ONCE, SCREENS, faint_texts, seen, sideways, violations
from tests.docs.site import ROOT, Page, broken_links, built_once, pages
from tests.headless import logs, small_window, waiting

pytestmark = pytest.mark.slow

MEGABYTE = 1_000_000
LOCAL = ("file:", "data:", "blob:", "about:")
JUDGED = [
    "index.html", "gallery.html", "reference/command_line.html", "reference/python.html", "notebooks/puma560.html",
    "explanation/two_roads.html", "search.html",
]  # fmt: skip


@pytest.fixture(scope="module")
def site(tmp_path_factory, worker_id):
    base = tmp_path_factory.getbasetemp()
    return built_once(base if worker_id == "master" else base.parent)


def size(folder):
    """Bytes of all files."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and ".doctrees" not in path.parts)


def cards():
    """The cards of the gallery."""
    return tomllib.loads((ROOT / "docs" / "gallery.toml").read_text(encoding="utf-8"))["card"]


def test_the_site_is_small_and_every_card_of_the_gallery_has_its_page_and_its_stills(site):
    assert len(cards()) >= 8
    text = (site / "gallery.html").read_text(encoding="utf-8")
    for card in cards():
        assert (site / "gallery_pages" / f"{card['name']}.html").is_file()
        for still in (f"{card['name']}.webp", f"{card['name']}_dark.webp"):
            assert (site / "_static" / "stills" / still).is_file(), "take it: scripts/site_stills.py"
            assert f"_static/stills/{still}" in text
    assert size(site) < 25 * MEGABYTE
    assert size(site / "gallery_pages") < 14 * MEGABYTE


def test_a_broken_link_is_seen(tmp_path):
    (tmp_path / "a.html").write_text('<a href="b.html#here">', encoding="utf-8")
    assert list(broken_links(tmp_path)) == ["a.html: b.html#here: no such file"]
    (tmp_path / "b.html").write_text('<p id="there">', encoding="utf-8")
    assert list(broken_links(tmp_path)) == ["a.html: b.html#here: no such anchor"]
    (tmp_path / "b.html").write_text('<p id="here">', encoding="utf-8")
    assert list(broken_links(tmp_path)) == []


def test_every_link_leads_somewhere_and_every_name_and_command_stands_in_the_reference(site):
    python = Page(site / "reference" / "python.html")
    assert {f"lwr_dyn.{name}" for name in lwr_dyn.__all__} <= python.anchors
    commands = Page(site / "reference" / "command_line.html")
    assert set(COMMANDS.names) <= commands.anchors
    text = (site / "reference" / "python.html").read_text(encoding="utf-8")
    entry = re.search(r'id="load".*?</section>', text, re.DOTALL)
    assert entry is not None
    assert "Used in: " in entry[0]
    assert list(broken_links(site)) == []


def test_the_notebook_of_the_puma_has_the_numbers_of_the_tests():
    notebook = (ROOT / "docs" / "notebooks" / "puma560.md").read_text(encoding="utf-8")
    written = re.search(r"%%writefile puma560.toml\n(.*?)```", notebook, re.DOTALL)
    assert written is not None
    tested = (ROOT / "tests" / "dynamics" / "puma560.toml").read_text(encoding="utf-8")
    assert tomllib.loads(written[1]) == tomllib.loads(tested)


def test_no_page_asks_a_network_or_complains(site, browser):
    asked, said = {}, {}
    browser.get("about:blank")
    logs(browser)
    with small_window(browser):
        for page in pages(site):
            browser.get(page.as_uri())
            sent, messages = logs(browser)
            name = page.relative_to(site).as_posix()
            asked[name] = [address for address in sent if not address.startswith(LOCAL)]
            said[name] = messages
    assert len(asked) > 30
    assert {name: sent for name, sent in asked.items() if sent} == {}
    assert {name: messages for name, messages in said.items() if messages} == {}


def test_the_search_finds_pages_without_a_server(site, browser):
    logs(browser)
    browser.get((site / "search.html").as_uri() + "?q=payload")
    found = "return [...document.querySelectorAll('#search-results a')].map((a) => a.getAttribute('href'))"
    waiting(browser, 30).until(lambda window: window.execute_script(found))
    assert any("payload" in address for address in browser.execute_script(found))
    sent, messages = logs(browser)
    assert [address for address in sent if not address.startswith(LOCAL)] == []
    assert messages == []


def test_a_still_becomes_a_live_page_that_needs_no_network(site, browser):
    browser.get((site / "index.html").as_uri())
    logs(browser)
    browser.execute_script("document.querySelector('a.still').click()")
    frame = browser.find_element("css selector", "iframe.live")
    assert frame.get_attribute("title") == cards()[0]["title"]
    browser.switch_to.frame(frame)
    ready = "return !!(window.lwrReplay && lwrReplay.ready)"
    waiting(browser, 60).until(lambda window: window.execute_script(ready))
    browser.switch_to.default_content()
    sent, _ = logs(browser)
    assert [address for address in sent if not address.startswith(LOCAL)] == []


@pytest.mark.parametrize("name", JUDGED)
def test_a_page_breaks_no_rule_of_axe(name, site, browser):
    browser.get((site / name).as_uri())
    for width, dark in SCREENS if name == JUDGED[0] else EACH_ONCE:
        with seen(browser, width, dark):
            assert violations(browser) == []
            assert faint_texts(browser) == []
            assert sideways(browser) == 0, (name, width)
