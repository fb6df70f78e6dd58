"""`lwr-dyn show`: one page or a live one; bad input is one line."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.show import serve_arm
from lwr_dyn.pages.replay import live
from tests.headless import logs, waiting
from tests.pages.explorer.explored import FOREIGN, SHARE, opened

pytestmark = pytest.mark.usefixtures("folder")


@pytest.fixture
def run_file(folder, two_runs):
    two_runs[0].save(folder / "pd.npz")
    return "pd.npz"


@pytest.mark.slow
def test_a_robot_a_urdf_and_a_run_become_pages(lwr_dyn_command, printed, folder, run_file):
    out = printed("show", "lwr4plus", "--html", "x.html", "--q-deg", "10,20,30,-40,50,60,70")
    assert out.startswith("wrote x.html (1.")
    assert "open it: " in out
    assert "lwrExplorer" in (folder / "x.html").read_text(encoding="utf-8")
    code, out, _ = lwr_dyn_command("show", str(SHARE / FOREIGN["panda"]), "--tip", "panda_link8")
    assert code == 0
    assert out.startswith("wrote lwr_dyn_pages/panda_urdf_")
    assert printed("show", run_file).startswith("wrote lwr_dyn_pages/lwr4plus_pd-gravity_")


@pytest.mark.parametrize(
    ("words", "path", "q", "beside", "browser"),
    [
        ((), None, None, None, None),
        (("--html", "x.html", "--q-deg", "0,90,0,0,0,0,0", "--beside", "lwr4plus:printed", "--no-browser"), "x.html",
         np.radians([0, 90, 0, 0, 0, 0, 0]), ("lwr4plus", "printed"), False),
        (("--q", "0,0.5,0,0,0,0,0", "--beside", "wam7", "--browser"), None, [0, 0.5, 0, 0, 0, 0, 0], ("wam7", "manual"),
         True),
    ],
)  # fmt: skip
def test_what_is_typed_reaches_the_page(asked, printed, words, path, q, beside, browser):
    calls = asked("lwr_dyn.cli.show.show", "the page")
    assert printed("show", "lwr4plus", *words).splitlines()[-1] == "'the page'"
    (arm, where), given = calls[0]
    other = given["beside"] and (given["beside"].name, given["beside"].reading)
    assert (arm.name, where, other, given["browser"]) == ("lwr4plus", path, beside, browser)
    assert (given["q"] is None) == (q is None)
    if q is not None:
        np.testing.assert_allclose(given["q"], q)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("lwr4pluss",), "did you mean lwr4plus?"),
        (("none.npz",), "none.npz: no such file"),
        (("lwr4plus", "--html", "nowhere/x.html"), "no directory nowhere"),
        (("lwr4plus", "--html", "."), "is a directory"),
        (("lwr4plus", "--html", "x.html", "--serve"), "both --html and --serve"),
        (("lwr4plus", "--port", "1"), "only with --serve"),
        (("lwr4plus", "--serve", "--port", "70000"), "port: 70000"),
        (("lwr4plus", "--q-deg", "0,0"), "2 numbers"),
        (("lwr4plus", "--q-deg", "0,0,0,0,0,0,171"), "q of joint_7: 171 deg; allowed: its limits, -170 deg to 170 deg"),
        (("lwr4plus", "--tip", "x"), "only with a .urdf, "),
        (("pd.npz", "--reading", "printed"), "--reading: given for pd.npz; allowed: only with a robot"),
        (("pd.npz", "--lock", "joint_1=0"), "--lock: given for pd.npz"),
        (("pd.npz", "--mount", "ceiling"), "--mount: given for pd.npz"),
        (("pd.npz", "--q-deg", "0"), "--q-deg: given for pd.npz"),
        (("lwr4plus", "--beside", "wamm"), "did you mean wam7?"),
        (("lwr4plus", "--beside", "wam7:x"), "no reading of wam7 named 'x'"),
        (("lwr4plus", "--beside", "wam7:"), "allowed: ROBOT or ROBOT:READING"),
        (("lwr4plus", "--beside", "none.urdf"), "none.urdf: no such file"),
        (
            ("lwr4plus", "--beside", "wam7", "--serve"),
            "--beside: given with --serve; allowed: only with a robot's page",
        ),
        (("pd.npz", "--beside", "wam7"), "--beside: given for pd.npz"),
        (("unknown.npz",), "did you mean lwr4plus?"),
        (("nameless.npz",), "nameless.npz: does not say of which robot it is"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(refused, folder, run_file, two_runs, arguments, words):
    replace(two_runs[0], meta={**two_runs[0].meta, "robot": "lwr4pluss"}).save(folder / "unknown.npz")
    replace(two_runs[0], meta={}).save(folder / "nameless.npz")
    before = set(folder.iterdir())
    assert words in refused("show", *arguments)
    assert set(folder.iterdir()) == before


@pytest.mark.slow
def test_a_second_robot_stands_on_the_page_of_the_first(lwr_dyn_command, folder):
    for other, name in (("kr30ha", "kr30ha, reading kuka"), ("lwr4plus:printed", "lwr4plus, reading printed")):
        code, _, err = lwr_dyn_command("show", "lwr4plus", "--beside", other, "--html", "two.html")
        assert (code, err) == (0, "")
        assert f'<div data-for="arm-name">{name}</div>' in (folder / "two.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_pose_sent_to_a_live_page_moves_the_sliders(browser, arm):
    q = np.array([0.3, -0.4, 0.5, 0.9, -0.2, 0.7, 0.1])
    with serve_arm(arm, port=0) as server:
        opened(browser, server.url)
        waiting(browser, 20).until(
            lambda w: w.execute_script("return lwrExplorer.stage.viewer.num_messages_received > 10")
        )
        server.show(q)

        def there(window):
            return np.abs(np.array(window.execute_script("return lwrExplorer.positions()")) - q).max() < 1e-6

        waiting(browser, 20).until(there)
        pose = browser.execute_script("return lwrExplorer.drawnPose()")
        np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(arm, q), rtol=0, atol=1e-6)
        sent, said = logs(browser)
        allowed = (server.url, server.url.replace("http", "ws"), "data:", "blob:")
        assert all(address.startswith(allowed) for address in sent)
        assert said == []
        browser.get("about:blank")


def test_serve_says_where_until_it_is_interrupted(lwr_dyn_command, monkeypatch, run_file):
    def interrupted(server):
        raise KeyboardInterrupt

    monkeypatch.setattr(live.LiveReplay, "wait", interrupted)
    for what in ("kr30ha", run_file):
        code, out, err = lwr_dyn_command("show", what, "--serve", "--port", "0")
        assert code == 0
        estimated = "kr30ha (kuka): masses, centres of mass and inertias estimated from drawn solids"
        said = [] if what == run_file else [estimated]
        assert out.splitlines()[:-1] == said
        assert out.splitlines()[-1].startswith("http://127.0.0.1:")
        assert err == "closed\n"
