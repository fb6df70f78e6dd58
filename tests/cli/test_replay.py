"""`lwr-dyn replay`: files in, one page out; every bad input is one error that ends in exit code 2."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import pytest

from lwr_dyn.pages.replay import live

USUAL = {"labels": None, "title": None, "frames": False, "layout": "overlaid"}
CHOSEN = {"labels": ("one", "two"), "title": "t", "frames": True, "layout": "beside"}
OPTIONS = ("--label", "one", "--label", "two", "--side-by-side", "--frames", "--title", "t")


@pytest.fixture
def files(tmp_path, two_runs):
    paths = [tmp_path / "a.npz", tmp_path / "b.npz"]
    for run, path in zip(two_runs, paths, strict=True):
        run.save(path)
    return [str(path) for path in paths]


@pytest.mark.parametrize(("more", "options"), [((), USUAL), (OPTIONS, CHOSEN)])
def test_what_is_typed_reaches_the_page_and_the_server(files, asked, printed, folder, more, options):
    page = asked("lwr_dyn.pages.replay.replay_page.write_replay")
    served = asked("lwr_dyn.pages.replay.live.serve", nullcontext(SimpleNamespace(url="x", wait=lambda: None)))
    (folder / "x.html").write_text("x" * 60_000)
    said = "wrote x.html (0.1 MB, needs no network); open it: xdg-open x.html\n"
    assert printed("replay", *files, "--html", "x.html", *more) == said
    (path, runs, arms), given = page[0]
    assert (path, [run.meta["controller"] for run in runs], [arm.name for arm in arms], given) == (
        "x.html", ["pd-gravity", "inverse-dynamics"], ["lwr4plus"] * 2, options,
    )  # fmt: skip
    for port, number in (((), 7000), (("--port", "5"), 5)):
        assert printed("replay", *files, "--serve", *port, *more) == "x (Ctrl-C ends it)\n"
        assert served.pop()[1] == {"port": number, **options}


def test_two_files_become_one_page(files, printed, tmp_path):
    target = tmp_path / "out.html"
    printed("replay", *files, "--html", str(target), *OPTIONS)
    text = target.read_text(encoding="utf-8")
    assert '"label":"one"' in text
    assert '"beside":true' in text


def test_serve_answers_until_it_is_interrupted(files, lwr_dyn_command, monkeypatch):
    def interrupted(server):
        assert server.port > 0
        raise KeyboardInterrupt

    monkeypatch.setattr(live.LiveReplay, "wait", interrupted)
    code, out, err = lwr_dyn_command("replay", files[0], "--serve", "--port", "0")
    assert (code, err, out.startswith("http://127.0.0.1:")) == (0, "closed\n", True)
    assert out.endswith("/ (Ctrl-C ends it)\n")
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    code, _, err = lwr_dyn_command("replay", files[0], "--serve", "--port", "0", "--browser")
    assert (code, "no browser found" in err) == (2, True)


ALLOWED = "allowed: --html FILE or --serve; to look at once: lwr-dyn show "


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), f"replay: nothing to do; {ALLOWED}"),
        (("--serve", "--html", "x.html"), f"replay: both --html and --serve; {ALLOWED}"),
        (("--html", "x.html", "--port", "1"), "--port, --browser: given without --serve; allowed: only with --serve"),
        (("--html", "x.html", "--browser"), "--port, --browser: given without --serve; allowed: only with --serve"),
        (
            ("--html", "x.html", "--side-by-side"),
            "--side-by-side: would do nothing here; allowed: with two runs or more",
        ),
        (("--html", "nowhere/x.html"), "nowhere"),
    ],
)
def test_wrong_options(files, refused, options, message):
    assert message in refused("replay", files[0], *options)


def test_wrong_run_files(files, refused, tmp_path, two_runs):
    truncated, nameless = tmp_path / "cut.npz", tmp_path / "nameless.npz"
    whole = (tmp_path / "a.npz").read_bytes()
    truncated.write_bytes(whole[: len(whole) // 2])
    replace(two_runs[0], meta={}).save(nameless)
    for path, message in (
        (truncated, "not a whole run file"), (tmp_path / "none.npz", "no such file"), (nameless, "which robot"),
    ):  # fmt: skip
        assert message in refused("replay", str(path), "--html", str(tmp_path / "x.html"))
        assert not (tmp_path / "x.html").exists()
