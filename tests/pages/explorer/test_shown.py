"""`lwr_dyn.show`: a file, the line that opens it, the bundle of a notebook."""

import base64
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


@pytest.mark.slow
def test_an_arm_becomes_a_file_and_says_how_to_open_it(folder):
    page = lwr_dyn.show(lwr_dyn.load("lwr4plus"))
    assert page.path.as_posix() == "lwr_dyn_pages/lwr4plus.html"
    assert (folder / page.path).read_text(encoding="utf-8").startswith("<!doctype html>")
    assert repr(page).startswith("wrote lwr_dyn_pages/lwr4plus.html (1.")
    assert "open it: " in repr(page)


@pytest.mark.slow
def test_other_contents_have_other_files(small, two_runs):
    tool = lwr_dyn.load("lwr4plus", lock=HELD, tool={"xyz": [0, 0, 0.1]})
    pages = [lwr_dyn.show(one) for one in (small, tool, *two_runs)] + [lwr_dyn.show(small, q=[0.1] * 2)]
    names = [page.path.name for page in pages]
    names.append(lwr_dyn.show(small, beside=tool).path.name)
    assert len(set(names)) == 6
    assert names[2].startswith("lwr4plus_pd-gravity_")
    assert [lwr_dyn.show(one).path.name for one in (small, tool)] == names[:2]


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


@pytest.mark.slow
def test_a_browser_opens_on_a_terminal_with_a_display_only(small, monkeypatch):
    asked = []
    monkeypatch.setattr("webbrowser.open", lambda address: asked.append(address) or True)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    lwr_dyn.show(small)
    assert asked == []
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    page = lwr_dyn.show(small)
    assert asked == [page.path.resolve().as_uri()]
    lwr_dyn.show(small, browser=False)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: False, raising=False)
    lwr_dyn.show(small)
    assert len(asked) == 1


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
