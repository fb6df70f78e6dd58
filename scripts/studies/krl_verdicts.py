"""What counts as a false diagnosis of a public KRL program; written before the programs were checked.

Only errors count. A warning or a note may be right or idle: KSS runs the program all the same.

true     KSS refuses the line, or cannot run it, whatever else is installed.
missing  The name is declared nowhere in what was given and is none of KUKA's: the program needs a file that is not
         there, or the name is misspelt. KSS refuses it too.
unclear  Right or not depends on something that is not in the repository: a name of an option package that it does not
         bring, a form of a line that only some version of KSS has or that no public text decides.
false    KSS takes the line as it stands. Of two readings, the one that speaks against us.

A false *syntax* error is a false one about a line as such: its words, their order, blocks and where they end
(`SYNTAX_CODES`). A false *alarm* is any false error. No KSS was at hand: each verdict follows from a rule here or from
one row, with its reason, in the manifest; an error that neither decides counts as false, so no error passes unread.

The rules, for an error about an unknown name:
1. a name that its repository declares: missing where the program stands alone; false in its folder where it is GLOBAL,
   or in a `$config.dat`, or the first DEF of a file;
2. a name in the controller's own list (`operate*.dat` in one of the repositories), one with `$`, or one of the options
   whose manuals are public (EKI_, RSI_): false;
3. a name that a KUKA file of another repository shares (below a folder System, TP or Mada), or one that begins like
   an option's (`OPTIONS`): unclear;
4. any other: missing.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, Literal

from lwr_dyn.krl.diagnostics import Diagnostic

Verdict = Literal["true", "missing", "unclear", "false"]
VERDICTS: tuple[Verdict, ...] = ("true", "missing", "unclear", "false")
SYNTAX_CODES = frozenset(
    {"syntax", "bad-literal", "bad-character", "unknown-keyword", "missing-type", "long-line", "late-declaration"}
    | {"initialiser-in-src", "outside-routine", "stray-end", "missing-end", "open-string", "open-bracket", "bad-name"}
)
PUBLIC_OPTIONS = re.compile(r"(EKI|RSI)_")
OPTIONS = re.compile(
    r"MSG(NOTIFY|QUIT|STATE|DIALOG|LOOP)|(ST|GRP|GRIP|ARC|SPOT|LASER|CONV|TM|OPC|TOUCH|TECH|H70|A_ARC|A_FLY|A_FG)_|GRIPPER|[AH][1257]0"
    r"|USERSPOT|ARC20|FG_TOUCH|(CD0|DUMMY|GDEFAULT|POWER)$"
)
"""How the names of option packages begin; it makes a verdict unclear, so it speaks against us."""
_NAME = re.compile(r"^(?:the subprogram |the function )?(\S+) (?:is not declared|is not known|is no type)")
_DECLARED = re.compile(
    rb"(?im)^[ \t]*(?:GLOBAL[ \t]+)?(DECL|DEF|DEFFCT|ENUM|STRUC|SIGNAL|EXT|EXTFCT|EXTP|EXTFCTP|INT|REAL|BOOL|CHAR)\b"
    rb"[ \t]*([^\r\n;=(]*)"
)
_WORD = re.compile(r"[$A-Za-z_][$\w]*")


@dataclass(frozen=True, slots=True)
class CorpusNames:
    """Names in capitals, read without our parser: a line that declares yields all its words."""

    kernel: frozenset[str]
    supplied: Mapping[str, frozenset[str]]
    """By repository, of the files that KUKA supplies."""
    declared: Mapping[str, frozenset[str]]
    """By repository, of all its files."""
    shared: Mapping[str, frozenset[str]]
    """By repository, those that other modules see."""


def corpus_names(*folders: Path) -> CorpusNames:
    """Those of all repositories below folders, each `owner+name/...`."""
    kernel: set[str] = set()
    repositories = [x.name for folder in folders for x in folder.iterdir()]
    supplied, declared, shared = ({name: set[str]() for name in repositories} for _ in range(3))
    for folder, path in ((x, path) for x in folders for path in sorted(x.rglob("*"))):
        if path.suffix.lower() not in (".src", ".sub", ".dat") or not path.is_file():
            continue
        repository, *parts = path.relative_to(folder).parts
        text = path.read_bytes()
        words = declared_words(text)
        declared[repository] |= words
        public = words if path.name.lower() == "$config.dat" else shared_words(text)
        shared[repository] |= public
        if path.name.lower().startswith("operate"):
            kernel |= words
        elif {"system", "tp", "mada"} & {part.lower() for part in parts[:-1]}:
            supplied[repository] |= public
    return CorpusNames(frozenset(kernel), *(_frozen(x) for x in (supplied, declared, shared)))


def _frozen(names: Mapping[str, set[str]]) -> dict[str, frozenset[str]]:
    return {name: frozenset(words) for name, words in names.items()}


def shared_words(text: bytes) -> set[str]:
    """The words of the lines with GLOBAL, and the name of the first DEF."""
    first = re.search(rb"(?im)^[ \t]*DEF(?:FCT[ \t]+\w+)?[ \t]+(\w+)", text)
    lines = [line for line in text.splitlines() if re.match(rb"(?i)\s*(DECL\s+)?GLOBAL\b", line)]
    unmarked = (re.sub(rb"(?i)\bGLOBAL\b", b"", line) for line in lines)
    return declared_words(b"\n".join(unmarked)) | ({first.group(1).decode("latin-1").upper()} if first else set())


def declared_words(text: bytes) -> set[str]:
    """The words of the lines that declare, up to a value or an argument; of a type its name only."""
    out: set[str] = set()
    for keyword, rest in _DECLARED.findall(text):
        words = [word.upper() for word in _WORD.findall(rest.decode("latin-1"))]
        out.update(words[:1] if keyword.upper() in (b"ENUM", b"STRUC") else words)
    return out


@dataclass(frozen=True, slots=True)
class Judgement:
    """One row of the manifest: errors of a code in files of a repository, at these lines or at all."""

    repository: str
    file: str
    code: str
    verdict: Verdict
    why: str
    lines: tuple[int, ...] = ()
    names: tuple[str, ...] = ()

    def decides(self, repository: str, file: str, diagnosis: Diagnostic) -> bool:
        """Whether this row speaks of that error."""
        name = name_of(diagnosis)
        return (
            fnmatch(repository, self.repository)
            and fnmatch(file.lower(), self.file.lower())
            and fnmatch(diagnosis.code, self.code)
            and (not self.lines or diagnosis.position.line in self.lines)
            and (not self.names or (name is not None and any(fnmatch(name, x.upper()) for x in self.names)))
        )


def judgements(rows: Iterable[Mapping[str, Any]]) -> list[Judgement]:
    """The rows of a manifest."""
    return [
        Judgement(**{**row, "lines": tuple(row.get("lines", ())), "names": tuple(row.get("names", ()))}) for row in rows
    ]


def name_of(diagnosis: Diagnostic) -> str | None:
    """The unknown name of an error about one, in capitals."""
    found = _NAME.match(diagnosis.message)
    return None if found is None else found.group(1).upper()


@dataclass(slots=True, eq=False)
class Judge:
    """Gives each error its verdict: rows of the manifest first, then the rules; `undecided` keeps what none decides."""

    names: CorpusNames
    rows: list[Judgement]
    undecided: list[tuple[str, Diagnostic]] = field(default_factory=list)

    def verdict(self, repository: str, file: str, diagnosis: Diagnostic, *, alone: bool) -> Verdict:
        """Of an error in a file, by its path within its repository; `alone`: checked without the other files."""
        row = next((x for x in self.rows if x.decides(repository, file, diagnosis)), None)
        if row is not None:
            return row.verdict
        name = name_of(diagnosis)
        if name is None:
            self.undecided.append((f"{repository}/{file}", diagnosis))
            return "false"
        return self._of_name(repository, name, alone)

    def _of_name(self, repository: str, name: str, alone: bool) -> Verdict:
        if alone and name in self.names.declared.get(repository, ()):
            return "missing"
        if not alone and name in self.names.shared.get(repository, ()):
            return "false"
        if name in self.names.kernel or name.startswith("$") or PUBLIC_OPTIONS.match(name):
            return "false"
        others = (words for other, words in self.names.supplied.items() if other != repository)
        return "unclear" if OPTIONS.match(name) or any(name in words for words in others) else "missing"
