"""The extension for VS Code: its colours agree with the lexer, its guard keeps bytes, its package holds what it should.

The packages of npm are those of the lock file; a real editor is tried by `scripts/soak.py editor`.
"""

import json
import os
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from lwr_dyn.foundation.version import VERSION
from lwr_dyn.krl.language.lexer import KEYWORDS, LineError, tokens_of
from lwr_dyn.krl.language.source import parse_text
from lwr_dyn.krl.names.known_names import GEOMETRY
from scripts.build_grammar import GRAMMAR, grammar, groups, main, soft_words
from scripts.build_vsix import EDITOR, FILES, build
from tests.krl.random_programs import Writer
from tests.krl.small_backup import FILES as BACKUP

PROGRAMS = Path(__file__).resolve().parents[1] / "krl"
LARGEST = 150_000
"""[bytes] Of the package."""
SCOPES = {
    "NAME": r"variable|entity|constant\.other",
    "ENUMERATION": r"constant\.other\.enum",
    "STRING": r"string",
    "BITS": r"constant\.numeric\.bits",
    "DECIMAL": r"constant\.numeric\.krl",
    "INTEGER": r"constant\.numeric\.krl",
    "keyword": r"keyword|storage|support|constant\.language",
    "soft": r"keyword\.control|storage\.modifier|variable|entity",
    "structure": r"storage\.type",
}
"""What a token of the lexer may look like."""


def kind_of(token):
    """The row of `SCOPES` of a token, None for signs."""
    if token.kind == "NAME" and token.text.upper() in GEOMETRY:
        return "structure"
    if token.kind != "NAME" and token.text.upper() in KEYWORDS:
        return "soft" if token.text.upper() in soft_words() else "keyword"
    return token.kind if token.kind in SCOPES else None


def lines_of_tokens():
    """Each line of the project's own programs, written and drawn, that the lexer reads, with its coloured tokens."""
    files = [path for path in sorted(PROGRAMS.rglob("*")) if path.suffix in (".src", ".dat", ".sub")]
    texts = [*BACKUP.values(), *(path.read_text(encoding="latin-1") for path in files)]
    texts += [Writer(seed).file().text() for seed in range(400)]
    for text in dict.fromkeys(line for source in texts for line in source.splitlines()):
        if text.lstrip().startswith("&"):
            continue
        try:
            tokens, _ = tokens_of(text)
        except LineError:
            continue
        yield text, [(token.column - 1, kind_of(token), token.text) for token in tokens if kind_of(token)]


def disagreements(lines, scopes):
    """Tokens whose scope is not one that their kind may have."""
    return [
        (text, word, kind, scope)
        for (text, tokens), found in zip(lines, scopes, strict=True)
        for (_, kind, word), scope in zip(tokens, found, strict=True)
        if not re.match(SCOPES[kind], scope)
    ]


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """The packages of the lock file; absent npm fails the run in CI and skips it elsewhere."""
    if shutil.which("npm") is None and not os.environ.get("CI"):
        pytest.skip("npm is not installed (Debian: npm)")
    folder = tmp_path_factory.mktemp("packages")
    for name in ("package.json", "package-lock.json"):
        shutil.copy(EDITOR / name, folder)
    command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
    subprocess.run(command, cwd=folder, check=True, timeout=300, stdin=subprocess.DEVNULL)
    return folder / "node_modules"


def node(*arguments, text=None, modules=None):
    """What node prints; the whole is shown where it fails."""
    env = {**os.environ, **({} if modules is None else {"NODE_PATH": str(modules)})}
    command = ["node", *map(str, arguments)]
    result = subprocess.run(command, input=text, text=True, capture_output=True, env=env, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def scopes_of(asked, packages):
    """What the grammar makes of the words that begin at columns of lines."""
    return json.loads(node(EDITOR / "test/agree.js", GRAMMAR, text=json.dumps(asked), modules=packages))


@pytest.mark.slow
def test_colours_agree_with_the_lexer(packages):
    lines = list(lines_of_tokens())
    scopes = scopes_of([[text, [column for column, _, _ in tokens]] for text, tokens in lines], packages)
    assert sum(len(tokens) for _, tokens in lines) > 10000
    assert disagreements(lines, scopes) == []


LINES = [
    ("FOR i=1 TO 9 STEP 2", {"STEP": "keyword.control"}),
    ("  step.Y = 60.0*(i-1)", {"step": "variable.other"}),
    ("LIN step:pick C_DIS", {"LIN": "support.function.motion", "step": "variable.other", "C_DIS": "support"}),
    ("WAIT SEC 0.2", {"WAIT": "keyword.control", "SEC": "keyword.control"}),
    ("TRIGGER WHEN PATH=0 DELAY=0 DO f( )", {"PATH": "keyword", "DELAY": "keyword", "f": "entity.name.function"}),
    ("P = {X 1, OUT 2, T 3}", {"OUT": "variable.other.property", "T": "variable.other.property"}),
    ("STRUC s INT in, REAL out", {"INT": "storage.type", "in": "variable", "out": "variable"}),
    ("DEFDAT a PUBLIC", {"DEFDAT": "keyword", "a": "entity.name.module", "PUBLIC": "storage.modifier"}),
    (";FOLD PTP P1 Vel=100 %;%{PE}%R 8", {"FOLD": "keyword.other.fold", "PTP": "entity.name", "PE": "comment"}),
    ("GLOBAL DEFFCT CHAR[15] g( )", {"GLOBAL": "storage", "CHAR": "storage.type", "15": "constant.numeric"}),
]
"""Lines, and what some of their words look like."""


@pytest.mark.slow
def test_colours_of_chosen_lines(packages):
    asked = [[text, [re.search(rf"\b{word}\b", text).start() for word in wanted]] for text, wanted in LINES]
    for (text, wanted), found in zip(LINES, scopes_of(asked, packages), strict=True):
        looks = dict(zip(wanted, found, strict=True))
        assert (text, [x for x in wanted if not looks[x].startswith(wanted[x])]) == (text, []), looks


@pytest.mark.slow
def test_the_package_holds_what_it_should_and_is_small(packages, tmp_path):
    out, again = tmp_path / "a.vsix", tmp_path / "b.vsix"
    build(out, packages)
    build(again, packages)
    assert out.read_bytes() == again.read_bytes()
    assert out.stat().st_size < LARGEST
    with zipfile.ZipFile(out) as package:
        names = {"[Content_Types].xml", "extension.vsixmanifest", "extension/dist/extension.js"}
        assert set(package.namelist()) == names | {f"extension/{x}" for x in (*FILES, "THIRD_PARTY.txt")}
        licences = package.read("extension/THIRD_PARTY.txt").decode()
        script = package.read("extension/dist/extension.js").decode()
        manifest = package.read("extension.vsixmanifest").decode()
    assert "vscode-languageclient 11.0.0: MIT" in licences
    assert "Permission is hereby granted" in licences
    assert f'Version="{VERSION}"' in manifest
    assert set(re.findall(r'require\("([^"]+)"\)', script)) <= BUILT_IN


BUILT_IN = {
    "vscode", "child_process", "crypto", "fs", "net", "os", "path", "process", "readline", "url", "util",
    "worker_threads", "node:child_process", "node:fs", "node:fs/promises", "node:os", "node:path",
}  # fmt: skip
"""What the script may ask of node and of the editor: nothing that is not in it."""


@pytest.mark.slow
def test_the_guard_of_bytes_the_search_for_python_and_the_commands():
    printed = node("--test", "--test-reporter=tap", *sorted((EDITOR / "test").glob("*.test.js")))
    assert int(re.search(r"^# pass (\d+)$", printed, re.M)[1]) >= 30
    assert re.search(r"^# fail 0$", printed, re.M)


def test_the_grammar_is_fresh_and_knows_each_keyword_once(tmp_path, capsys):
    assert main(["--check"]) == 0
    path = tmp_path / "krl.json"
    assert main(["--check"], path) == 1
    assert main([], path) == 0
    assert json.loads(path.read_text(encoding="utf-8")) == grammar()
    words = [word for group in groups().values() for word in group]
    assert len(words) == len(set(words))
    assert set(words) == set(KEYWORDS) | set(GEOMETRY)
    assert "stale" in capsys.readouterr().out


def read(name):
    return json.loads((EDITOR / name).read_text(encoding="utf-8"))


def test_what_the_manifest_says():
    manifest, lock = read("package.json"), read("package-lock.json")
    assert manifest["version"] == lock["version"] == VERSION
    assert lock["packages"][""]["devDependencies"] == manifest["devDependencies"]
    # models stay XML, and data files are claimed by their place or first line
    krl, xml = manifest["contributes"]["languages"]
    assert (krl["extensions"], xml) == ([".src", ".sub"], {"id": "xml", "extensions": [".urdf", ".xacro"]})
    assert all(pattern.startswith(("**/KRC/", "**/R[1-6]/", "**/STEU/", "$")) for pattern in krl["filenamePatterns"])
    lines = ["&ACCESS RVP", "DEFDAT a PUBLIC", "defdat a", "DEFDATA", "&amp;", "1 2 3"]
    assert [bool(re.match(krl["firstLine"], x)) for x in lines] == [True] * 3 + [False] * 3
    # a save of a program is asked first and changes nothing by itself
    settings = manifest["contributes"]["configurationDefaults"]
    kind = re.search(r'KIND = "([\w.-]+)"', (EDITOR / "src/guard.js").read_text(encoding="utf-8"))[1]
    assert all(settings[language]["editor.codeActionsOnSave"] == {kind: "always"} for language in ("[krl]", "[xml]"))
    off = ["autoGuessEncoding", "insertFinalNewline", "trimFinalNewlines", "trimTrailingWhitespace"]
    assert [settings["[krl]"][f"files.{name}"] for name in (*off, "autoSave")] == [*[False] * 4, "off"]


def expanded(body):
    """A snippet as it stands when nothing is changed in it."""
    text = body if isinstance(body, str) else "\n".join(body)
    text = re.sub(r"\$\{\d+\|([^,|]+)[^}]*\}", r"\1", text)
    for _ in range(3):
        text = re.sub(r"(?<!\\)\$\{\d+:((?:[^{}\\]|\\.)*)\}", r"\1", text)
    return re.sub(r"(?<!\\)\$(?:\d|TM_SELECTED_TEXT)|\$\{\d\}", "", text).replace("\\$", "$")


@pytest.mark.parametrize("name", read("snippets/krl.json"))
def test_a_snippet_is_krl(name):
    file, faults = parse_text(expanded(read("snippets/krl.json")[name]["body"]) + "\n")
    assert faults == ()
    assert not re.search(r"\$\{|\|", file.text())


def test_a_snippet_with_a_fault_is_seen():
    assert parse_text(expanded(["IF ${1:a} THN", "$0"]))[1] != ()
