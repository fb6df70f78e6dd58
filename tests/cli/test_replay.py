"""`lwr-dyn replay`: files in, one page out; every bad input is one error that ends in exit code 2."""

from dataclasses import replace

import pytest

from lwr_dyn.pages.replay import live


@pytest.fixture
def files(tmp_path, two_runs):
    paths = [tmp_path / "a.npz", tmp_path / "b.npz"]
    for run, path in zip(two_runs, paths, strict=True):
        run.save(path)
    return [str(path) for path in paths]


def test_two_files_become_one_page(files, printed, tmp_path):
    target = tmp_path / "out.html"
    labels = ("--label", "one", "--label", "two", "--side-by-side", "--frames")
    out = printed("replay", *files, "--html", str(target), *labels)
    size = f"{target.stat().st_size / 1e6:.1f} MB"
    assert out == f"wrote {target} ({size}, needs no network); open it: xdg-open {target}\n"
    text = target.read_text(encoding="utf-8")
    assert '"label":"one"' in text
    assert '"beside":true' in text


def test_serve_answers_until_it_is_interrupted(files, lwr_dyn_command, monkeypatch):
    def interrupted(server):
        assert server.port > 0
        raise KeyboardInterrupt

    monkeypatch.setattr(live.LiveReplay, "wait", interrupted)
    code, out, _ = lwr_dyn_command("replay", files[0], "--serve", "--port", "0")
    assert code == 0
    assert "http://127.0.0.1:" in out


def test_a_missing_browser_is_an_error(files, lwr_dyn_command, monkeypatch):
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    code, _, err = lwr_dyn_command("replay", files[0], "--serve", "--port", "0", "--browser")
    assert code == 2
    assert "no browser found" in err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "nothing to do"),
        (("--serve", "--html", "x.html"), "both --html and --serve"),
        (("--html", "x.html", "--port", "1"), "only with --serve"),
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
        (truncated, "not a whole run file"),
        (tmp_path / "none.npz", "no such file"),
        (nameless, "which robot"),
    ):
        assert message in refused("replay", str(path), "--html", str(tmp_path / "x.html"))
        assert not (tmp_path / "x.html").exists()
