"""`lwr_dyn.show`: a file, the line that opens it, the bundle of a notebook."""

import base64
import hashlib
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, OptionError, ShapeError, UnknownNameError

HELD = {f"joint_{j}": 0.5 for j in (3, 4, 5, 6, 7)}
"""Of the arms that are shown here: a page of two joints is made in a quarter of the time that one of seven takes."""


@pytest.fixture(scope="module")
def small():
    return lwr_dyn.load("lwr4plus", lock=HELD)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("webbrowser.open", lambda address: pytest.fail(f"opened {address}"))
    return tmp_path


@pytest.fixture
def notebook(monkeypatch):
    monkeypatch.setitem(
        sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=1), version_info=(9, 0))
    )


@pytest.fixture
def drawn(monkeypatch):
    """Pages that are not made: the arguments of those that are asked for stand in them."""
    monkeypatch.setattr("lwr_dyn.pages.explorer.shown.explorer_html", lambda arm, q, beside: f"{arm.name} {q} {beside}")
    monkeypatch.setattr("lwr_dyn.pages.explorer.shown.replay_html", lambda runs, arm: f"replay {runs[0].meta}")


@pytest.mark.slow
def test_an_arm_becomes_a_file_and_says_how_to_open_it(folder):
    page = lwr_dyn.show(lwr_dyn.load("lwr4plus"))
    text = (folder / page.path).read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    size = f"{len(text.encode()) / 1e6:.1f}"
    name = "lwr_dyn_pages/lwr4plus.html"
    assert repr(page) == f"wrote {name} ({size} MB, needs no network); open it: xdg-open {name}"


@pytest.mark.parametrize(("system", "opener"), [("darwin", "open"), ("win32", "start"), ("linux", "xdg-open")])
def test_a_page_is_opened_as_the_system_does(drawn, monkeypatch, system, opener):
    page = lwr_dyn.show(lwr_dyn.load("lwr4plus"), browser=False)
    monkeypatch.setattr(sys, "platform", system)
    assert repr(page) == f"wrote {page.path} (0.0 MB, needs no network); open it: {opener} {page.path}"


def test_other_contents_have_other_files(small, two_runs, drawn):
    """NAME.html of a plain arm by name; else eight letters of the page's digest stand behind it."""
    plain, tool = lwr_dyn.load("lwr4plus"), lwr_dyn.load("lwr4plus", tool={"xyz": [0, 0, 0.1]})
    pages = [lwr_dyn.show(one) for one in (plain, small, tool, *two_runs)]
    pages += [lwr_dyn.show(plain, q=[0.1] * 7), lwr_dyn.show(plain, beside=tool)]
    names = [page.path.name for page in pages]
    assert names[0] == "lwr4plus.html"
    stems = ["lwr4plus_", "lwr4plus_", "lwr4plus_pd-gravity_", "lwr4plus_inverse-dynamics_", "lwr4plus_", "lwr4plus_"]
    for page, name, stem in zip(pages[1:], names[1:], stems, strict=True):
        digest = hashlib.sha256(page.path.read_bytes()).hexdigest()[:8]
        assert name == f"{stem}{digest}.html"
    assert pages[6].title == f"{plain.title} beside {tool.title}"
    assert pages[0].title == plain.title


def test_a_run_shows_its_replay(two_runs, tmp_path):
    page = lwr_dyn.show(two_runs[0], tmp_path / "run.html")
    assert "lwrReplay" in page.path.read_text(encoding="utf-8")


def test_a_notebook_gets_an_iframe_on_the_file_a_picture_and_words(small, two_runs, notebook, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)  # the picture needs none
    page = lwr_dyn.show(small)
    bundle = page._repr_mimebundle_(include=None, exclude=None)
    assert set(bundle) == {"text/html", "text/plain", "image/png"}
    assert f'src="{page.path.as_posix()}" title="KUKA LWR 4+' in bundle["text/html"]
    assert base64.b64decode(bundle["image/png"]).startswith(b"\x89PNG")
    assert base64.b64decode(lwr_dyn.show(two_runs[0])._repr_mimebundle_()["image/png"]).startswith(b"\x89PNG")
    assert not any(part.startswith(".") for part in page.path.parts)  # Jupyter serves no hidden folder


@pytest.mark.slow
def test_embed_keeps_the_page_in_the_cell_and_writes_nothing(small, notebook, folder):
    page = lwr_dyn.show(small, embed=True)
    assert page.path is None
    assert 'srcdoc="&lt;!doctype html&gt;' in page._repr_mimebundle_()["text/html"]
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("system", "terminal", "display", "asked_for", "opened"),
    [
        ("linux", True, None, None, False), ("linux", True, "WAYLAND_DISPLAY", None, True),
        ("linux", True, "DISPLAY", None, True), ("linux", False, "DISPLAY", None, False),
        ("darwin", True, None, None, True), ("win32", True, None, None, True), ("darwin", False, None, None, False),
        ("linux", True, "DISPLAY", False, False), ("linux", False, None, True, True),
    ],
)  # fmt: skip
def test_a_browser_opens_on_a_terminal_with_a_display_or_where_it_is_asked_for(
    small, drawn, monkeypatch, system, terminal, display, asked_for, opened
):
    asked = []
    monkeypatch.setattr("webbrowser.open", lambda address: asked.append(address) or True)
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal, raising=False)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    if display:
        monkeypatch.setenv(display, "0")
    page = lwr_dyn.show(small, browser=asked_for)
    assert asked == [page.path.resolve().as_uri()] * opened


def test_bad_input_is_one_clear_line_and_leaves_no_file(small, two_runs, folder, monkeypatch):
    monkeypatch.setattr("webbrowser.open", lambda address: False)
    unknown = replace(two_runs[0], meta={**two_runs[0].meta, "robot": "lwr4pluss"}, setup=None)
    nameless = replace(two_runs[0], meta={}, setup=None)
    cases = [
        (lambda: lwr_dyn.show("lwr4plus"), OptionError, "shown: 'lwr4plus'; allowed: an arm or a run"),
        (lambda: lwr_dyn.show(unknown), UnknownNameError, "did you mean lwr4plus?"),
        (lambda: lwr_dyn.show(nameless), OptionError, "does not say of which robot it is"),
        (lambda: lwr_dyn.show(small, folder / "no" / "x.html"), FileAccessError, "no directory"),
        (lambda: lwr_dyn.show(small, q=[9.0] * 2), OptionError, "q of joint_1"),
        (lambda: lwr_dyn.show(small, q=[0.0]), ShapeError, "q: 1 number"),
        (lambda: lwr_dyn.show(two_runs[0], q=[0.0] * 7), OptionError, "q: given for a run"),
        (lambda: lwr_dyn.show(two_runs[0], beside=small), OptionError, "beside: given for a run"),
        (lambda: lwr_dyn.show(small, beside="wam7"), OptionError, "beside: 'wam7'; allowed: an arm"),
        (lambda: lwr_dyn.show(small, "x.html", embed=True), OptionError, "embed: with a path"),
    ]
    for call, error, words in cases:
        with pytest.raises(error) as fault:
            call()
        assert words in str(fault.value)
        assert "\n" not in str(fault.value)
    assert list(folder.iterdir()) == []
    with pytest.raises(OptionError, match="no browser found"):
        lwr_dyn.show(small, browser=True)
