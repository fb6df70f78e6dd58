"""The extension of editors/vscode in a real VS Code (code-server) with a browser: bytes, marks, pages, screenshots."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

ROOT = Path(__file__).resolve().parents[2]
EXTENSION = ROOT / "editors" / "vscode"
CODE_SERVER = "code-server@4.100.3"  # VS Code 1.100, the first with the encoding of a document; newer ones need node 22
FOLDER = Path(os.environ.get("LWR_DYN_EDITOR") or Path(tempfile.gettempdir()) / "lwr_dyn_editor")
"""Where code-server stays between runs, and where the screenshots are written."""
PORT = 18199
LOCAL = ("--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost",)
BROKEN = b"DEF broken( )\r\n; gr\xfcn\r\nDECL INT count\r\ncuont = 1\r\nPTP {A1 0, A2 -90\r\nEND\r\n"
ENDS = b"DEF ends( )\r\n; one\n; gr\xfcn\r\nEND\r\n"
ODD = b'<?xml version="1.0"?>\n<robot name="gr\xfcn">\n  <link name="a"/>\n</robot>\n'
LIGHT = b"""<?xml version="1.0"?>
<robot name="light">
  <link name="base"/>
  <link name="arm">
    <inertial><mass value="-1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="9"/></inertial>
  </link>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 0"/></joint>
</robot>
"""


def run(*command: str | Path, where: Path = FOLDER, may_fail: bool = False) -> None:
    """A command, quietly; raises with its last lines where it fails."""
    result = subprocess.run(list(map(str, command)), cwd=where, capture_output=True, text=True, check=False)
    if result.returncode and not may_fail:
        raise RuntimeError(f"{command[0]}: {(result.stderr or result.stdout).strip()[-400:]}")


def installed() -> Path:
    """The program of code-server, installed at the first call: its own script of installation asks for other users."""
    entry = FOLDER / "node_modules/code-server/out/node/entry.js"
    vscode = FOLDER / "node_modules/code-server/lib/vscode"
    if not (vscode / "node_modules.asar").exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        run("npm", "init", "-y")
        run("npm", "install", CODE_SERVER, "--ignore-scripts")
        run("npm", "rebuild", "argon2", "--foreground-scripts")
        run("npm", "install", "--omit=dev", "--ignore-scripts", where=vscode)
        run("npm", "rebuild", "@vscode/spdlog", "native-watchdog", where=vscode, may_fail=True)
        (vscode / "node_modules.asar").symlink_to("node_modules")
    return entry


def build_extension() -> None:
    """The extension as it would be installed."""
    packages, out = FOLDER / "extension", FOLDER / "lwr-dyn.vsix"
    packages.mkdir(exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(EXTENSION / name, packages)
    run("npm", "ci", "--ignore-scripts", where=packages)
    run(sys.executable, ROOT / "scripts/build_vsix.py", "--modules", packages / "node_modules", out, where=ROOT)


@contextmanager
def served(settings: dict[str, Any]) -> Iterator[None]:
    """A fresh VS Code with the extension, until the end of the block."""
    data = Path(tempfile.mkdtemp(dir=FOLDER))
    (data / "Machine").mkdir()  # a window of a server takes settings of the machine from there, not from the user
    (data / "Machine/settings.json").write_text(json.dumps(settings), encoding="utf-8")
    (data / "config.yaml").write_text(f"bind-addr: 127.0.0.1:{PORT}\n", encoding="utf-8")
    command = ["node", installed(), "--config", data / "config.yaml", "--user-data-dir", data]
    command += ["--extensions-dir", data / "extensions"]
    run(*command, "--install-extension", FOLDER / "lwr-dyn.vsix")
    quiet = ["--auth", "none", "--disable-telemetry", "--disable-update-check", "--disable-workspace-trust"]
    server = subprocess.Popen([*map(str, command), *quiet], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        server.terminate()
        server.wait(20)
        shutil.rmtree(data, ignore_errors=True)


@dataclass
class Window:
    """The editor's window, by what a user does and sees."""

    browser: Any
    folder: Path

    def open(self, name: str) -> None:
        """Open a file of the folder in a fresh window, and wait until its text stands."""
        file = json.dumps([["openFile", f"vscode-remote://localhost:{PORT}{self.folder / name}"]])
        self.browser.get(f"http://localhost:{PORT}/?folder={self.folder}&payload={quote(file)}")
        self.until(lambda: self.find(".monaco-editor .view-line"), 90)
        self.until(lambda: any(x.endswith("lwr-dyn") for x in self.status()), 60)
        self.until(lambda: not self.find(".statusbar-item .codicon-sync"), 60)
        time.sleep(2)

    def find(self, selector: str) -> list[Any]:
        """What is on the page now."""
        return self.browser.find_elements("css selector", selector)

    def texts(self, selector: str) -> list[str]:
        """The texts of what is on the page."""
        return [element.text.strip() for element in self.find(selector)]

    def status(self) -> list[str]:
        """The parts of the status bar."""
        return self.texts(".statusbar-item")

    def until(self, there: Callable[[], Any], seconds: float = 30) -> bool:
        """Whether it comes true in that time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                if there():
                    return True
            except Exception:  # the page is still changing
                pass
            time.sleep(0.2)
        return False

    def keys(self, *keys: str, held: str = "") -> None:
        """Type, with the keys held down that are given."""
        from selenium.webdriver.common.action_chains import ActionChains

        chain = ActionChains(self.browser)
        for key in held:
            chain.key_down(key)
        chain.send_keys(*keys)
        for key in held:
            chain.key_up(key)
        chain.perform()

    def control(self, key: str, times: int = 1) -> None:
        """A key with Control."""
        from selenium.webdriver.common.keys import Keys

        for _ in range(times):
            self.keys(key, held=Keys.CONTROL)
            time.sleep(0.1)

    def type_at(self, line: int, text: str) -> None:
        """At the beginning of a line that is on the screen, from 0."""
        from selenium.webdriver.common.keys import Keys

        self.find(".editor-instance .view-lines")[0].click()
        self.control(Keys.HOME)
        self.keys(Keys.ARROW_DOWN * line, Keys.HOME, text)
        time.sleep(1)

    def save(self) -> None:
        """As a user asks for it; and wait until it is done or refused."""
        self.control("s")
        time.sleep(3)

    def command(self, title: str) -> None:
        """Run a command by its title."""
        from selenium.webdriver.common.keys import Keys

        self.keys(Keys.F1)
        time.sleep(1)
        self.keys(title)
        time.sleep(1.5)
        self.keys(Keys.ENTER)

    def picture(self, name: str) -> None:
        """Keep what is seen."""
        self.browser.save_screenshot(str(FOLDER / f"{name}.png"))


def umlaut(w: Window) -> bool:
    """ü typed, saved, undone to the end and saved: the bytes of before, and only what was typed between"""
    file = w.folder / "KRC/R1/Program/pick_place.src"
    before = file.read_bytes()
    w.open("KRC/R1/Program/pick_place.src")
    read = w.until(lambda: "Windows 1252" in w.status())
    w.type_at(3, "; gr\u00fcn ")
    waited = file.read_bytes() == before  # nothing is saved after a delay
    w.save()
    lines = before.split(b"\r\n")
    typed = file.read_bytes() == b"\r\n".join([*lines[:3], b"; gr\xfcn " + lines[3], *lines[4:]])
    w.picture("umlaut")
    w.control("z", 15)
    w.save()
    return read and waited and typed and file.read_bytes() == before


def lacking(w: Window) -> bool:
    """A sign that Windows 1252 lacks is not saved, and the editor says so"""
    file = w.folder / "KRC/R1/Program/pick_place.src"
    before = file.read_bytes()
    w.type_at(3, "; \u0142 ")
    w.save()
    said = w.until(lambda: any("is not saved" in text for text in w.texts(".notification-list-item-message")), 10)
    kept = file.read_bytes() == before and bool(w.find(".tab.dirty"))
    w.picture("lacking")
    w.control("z", 8)
    return said and kept


def line_ends(w: Window) -> bool:
    """Lines that end in two ways are saved as one only when asked"""
    file = w.folder / "KRC/R1/Program/ends.src"
    w.open("KRC/R1/Program/ends.src")
    w.type_at(1, "; x ")
    w.save()
    refused = file.read_bytes() == ENDS
    w.picture("line_ends")
    for button in w.find(".notification-list-item .monaco-button"):
        if "Save all" in button.text:
            button.click()
            break
    wanted = ENDS.replace(b"one\n", b"one\r\n").replace(b"; one", b"; x ; one")
    return refused and w.until(lambda: file.read_bytes() == wanted, 10)


def read_only(w: Window) -> bool:
    """A URDF whose encoding is not known is shown read-only"""
    file = w.folder / "odd.urdf"
    w.open("odd.urdf")
    w.until(lambda: w.find(".tab .codicon-lock, .label-suffix .codicon-lock"), 10)
    w.type_at(1, "x")
    w.save()
    w.picture("read_only")
    return file.read_bytes() == ODD and not w.find(".tab.dirty")


def marks(name: str) -> Callable[[Window], bool]:
    def marked(w: Window) -> bool:
        w.open(name)
        found = w.until(lambda: w.find(".squiggly-error, .squiggly-warning"), 60)
        w.command("View: Toggle Problems")
        time.sleep(3)
        w.picture(f"marks_{Path(name).suffix[1:]}")
        return found

    marked.__doc__ = f"Faults are marked in a {Path(name).suffix}"
    return marked


def page(name: str, title: str, picture: str) -> Callable[[Window], bool]:
    def shown(w: Window) -> bool:
        w.open(name)
        w.command(title)
        drawn = w.until(lambda: w.find("iframe.webview"), 60) and w.until(lambda: _canvases(w), 40)
        time.sleep(4)
        w.picture(picture)
        return drawn

    shown.__doc__ = f"{title}: a page with a picture"
    return shown


def _canvases(w: Window) -> int:
    """In the page that is two frames deep."""
    browser = w.browser
    try:
        browser.switch_to.frame(w.find("iframe.webview")[0])
        browser.switch_to.frame(w.find("iframe#active-frame")[0])
        return len(w.find("canvas"))
    finally:
        browser.switch_to.default_content()


def whole_backup(w: Window) -> bool:
    """Check backup: the problems of files that are not open"""
    w.open("KRC/R1/Program/main.src")
    w.command("lwr-dyn: Check backup")
    shown = w.until(lambda: any("broken.src" in text for text in w.texts(".markers-panel .monaco-list-row")), 60)
    w.picture("whole_backup")
    return shown


def without_python(w: Window) -> bool:
    """Without Python: colours, no question, one sentence at the status bar"""
    w.open("KRC/R1/Program/pick_place.src")
    coloured = len({x.get_attribute("class") for x in w.find(".view-line span span")}) > 4
    quiet = not w.find(".notification-list-item-message")
    label = w.browser.find_element("css selector", "[id='lwr-dyn.lwr-dyn.lwr-dyn']").get_attribute("aria-label")
    w.picture("without_python")
    return coloured and quiet and "Colours, folds and snippets work" in label


TRIALS = (
    umlaut, lacking, line_ends, read_only,
    page("KRC/R1/Program/pick_place.src", "lwr-dyn: Run to a cycle time", "run"),
    page("arm.urdf", "lwr-dyn: Show arm", "arm"),
    whole_backup, marks("KRC/R1/Program/broken.src"), marks("light.urdf"),
)  # fmt: skip


def workspace(folder: Path) -> Path:
    """A small backup with faults, and three models."""
    from tests.krl.small_backup import write_backup

    write_backup(folder)
    programs = folder / "KRC/R1/Program"
    for name in ("pick_place.src", "pick_place.dat"):
        shutil.copy(ROOT / "tests/krl/programs" / name, programs)
    (programs / "broken.src").write_bytes(BROKEN)
    (programs / "ends.src").write_bytes(ENDS)
    (folder / "odd.urdf").write_bytes(ODD)
    (folder / "light.urdf").write_bytes(LIGHT)
    run(sys.executable, "-m", "lwr_dyn", "urdf", "kr30ha", "--out", folder / "arm.urdf", where=ROOT)
    return folder


def failures(trials: tuple[Callable[[Window], bool], ...], settings: dict[str, Any]) -> list[str]:
    """The sentences of the trials that fail in a fresh VS Code."""
    from tests.headless import browser_window

    with (
        tempfile.TemporaryDirectory() as files,
        tempfile.TemporaryDirectory() as profile,
        served(settings),
        browser_window(Path(profile), LOCAL) as browser,
    ):
        window, out = Window(browser, workspace(Path(files))), []
        for trial in trials:
            try:
                holds = trial(window)
            except Exception as fault:
                window.picture(f"failed_{len(out)}")
                out.append(f"{trial.__doc__} ({type(fault).__name__}: {str(fault)[:120]})")
            else:
                out += [] if holds else [str(trial.__doc__)]
        return out


def editor() -> tuple[str, bool]:
    """The extension in a real VS Code: bytes are kept, faults are marked, pages are shown."""
    installed()
    build_extension()
    found = ["env", f"PYTHONPATH={ROOT}", sys.executable, "-m", "lwr_dyn"]
    failed = failures((without_python,), {}) + failures(TRIALS, {"lwr-dyn.command": found})
    result = f"{len(TRIALS) + 1 - len(failed)} of {len(TRIALS) + 1} trials; pictures in {FOLDER}"
    return result + "".join(f"; fails: {one}" for one in failed), not failed
