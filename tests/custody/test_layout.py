"""The layout of the package: who may import whom for types, one meaning a class name, every module with its test."""

from __future__ import annotations

import ast
import re
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import pytest

from tests.custody.core_alone import CORE, core_files
from tests.own_tests import covered, own_tests

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "lwr_dyn"
TESTS = ROOT / "tests"
LONG = 100
"""Lines above which a module must have a test of its name, or a row in `tests/covered.toml`."""
LONGEST = 400
"""Lines at which a module is split by subject."""
COVERED = covered()
VAGUE = {"story", "told", "nobody", "anybody", "somebody"}
"""Words that no name and no docstring of the package uses."""


def modules(package: Path = PACKAGE) -> list[Path]:
    """All source files."""
    return sorted(package.rglob("*.py"))


def parsed(path: Path) -> ast.Module:
    """The syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def parsed_with(pattern: str, package: Path = PACKAGE) -> dict[str, ast.Module]:
    """The trees of the source files whose text has a pattern in any case, by place in the package: no other can."""
    having = [path for path in modules(package) if re.search(pattern, path.read_text(encoding="utf-8"), re.I | re.M)]
    return {path.relative_to(package).as_posix(): parsed(path) for path in having}


def length(path: Path) -> int:
    """Lines of a file."""
    return len(path.read_text(encoding="utf-8").splitlines())


def imports(tree: ast.AST) -> set[str]:
    """Dotted names of everything that is imported, `from a import b` as a.b."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


@cache
def imported_by(text: str) -> set[str]:
    """What a source imports; a test file is looked at for each module that it tests."""
    return imports(ast.parse(text))


FIRST_LEVEL = {
    "arms", "checks", "cli", "codegen", "control", "design", "dynamics", "foundation", "identification", "kinematics",
    "krl", "model", "pages", "reproduction", "simulation", "studies", "trajectory",
}  # fmt: skip


def test_every_folder_of_modules_is_a_package():
    assert sorted({p.parent for p in modules() if not (p.parent / "__init__.py").is_file()}) == []


def test_the_first_level_is_that_of_the_architecture():
    assert {path.parent.name for path in PACKAGE.glob("*/__init__.py")} == FIRST_LEVEL


def type_imports(tree: ast.Module) -> set[str]:
    """What is imported behind TYPE_CHECKING."""
    blocks = [node for node in ast.walk(tree) if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)]
    return {name for block in blocks for name in imports(block)}


def test_no_own_module_is_imported_for_types_alone():
    """Such an import holds a circle apart."""
    hiding = {name: type_imports(tree) for name, tree in parsed_with("TYPE_CHECKING").items()}
    assert {name: own for name, names in hiding.items() if (own := {n for n in names if n.startswith("lwr_dyn")})} == {}


def children(package: Path) -> set[str]:
    """Modules and sub-packages of a package."""
    modules = {path.stem for path in package.glob("*.py") if path.stem not in ("__init__", "__main__")}
    return modules | {path.parent.name for path in package.glob("*/__init__.py")}


def index(package: Path) -> set[str]:
    """The names that begin a row of the index in a package's docstring: `name  what lives there`."""
    text = ast.get_docstring(parsed(package / "__init__.py")) or ""
    return set(re.findall(r"^([a-z_0-9]+) {2,}\S", text, re.MULTILINE))


@pytest.mark.parametrize(
    "package", sorted(path.parent for path in PACKAGE.glob("*/**/__init__.py")), ids=lambda p: p.name
)
def test_the_index_of_a_package_names_what_is_there(package):
    assert index(package) == children(package)


def ambiguous(package: Path = PACKAGE) -> dict[str, list[str]]:
    """Names of classes that several modules define, with these; only where lines look so, trees are looked at."""
    lines = [re.findall(r"^\s*class (\w+)", path.read_text(encoding="utf-8"), re.M) for path in modules(package)]
    twice = {name for name, count in Counter(name for names in lines for name in names).items() if count > 1}
    places = defaultdict(list)
    for place, tree in parsed_with(rf"^\s*class ({'|'.join(twice)})\b", package).items() if twice else ():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(place)
    return {name: where for name, where in places.items() if len(where) > 1}


def test_a_class_name_has_one_meaning():
    assert ambiguous() == {}


def test_a_class_name_with_two_meanings_is_seen(tmp_path):
    (tmp_path / "a.py").write_text('class One: ...\nclass Two: ...\n"""\nclass Three\n"""\n', encoding="utf-8")
    (tmp_path / "b.py").write_text("def f():\n    class One: ...\nclass Three: ...\n", encoding="utf-8")
    assert ambiguous(tmp_path) == {"One": ["a.py", "b.py"]}


def test_no_module_is_long():
    lengths = {path.relative_to(PACKAGE).as_posix(): length(path) for path in modules()}
    assert {name: n for name, n in lengths.items() if n > LONGEST} == {}


def words(tree: ast.AST) -> set[str]:
    """The words of all names and docstrings, in lower case; a name is split at underscores and capitals."""
    texts = []
    for node in ast.walk(tree):
        texts += [text for field in ("name", "id", "attr", "arg", "asname") if (text := getattr(node, field, None))]
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            texts.append(node.value.value)
    found = [re.findall(r"[A-Z]?[a-z]+|[A-Z]+", text) for text in texts if isinstance(text, str)]
    return {word.lower() for each in found for word in each}


def vague(package: Path = PACKAGE) -> dict[str, set[str]]:
    """The vague words of the files that use some."""
    used = {name: words(tree) & VAGUE for name, tree in parsed_with("|".join(VAGUE), package).items()}
    return {name: found for name, found in used.items() if found}


def test_names_and_docstrings_use_plain_words():
    assert vague() == {}


@pytest.mark.parametrize(
    "text", ["told = 1", "def f(story_of): ...", "class SomebodyElse: ...", '"""What we are told."""']
)
def test_a_vague_word_is_seen(text, tmp_path):
    (tmp_path / "a.py").write_text(text, encoding="utf-8")
    (tmp_path / "b.py").write_text("stored = history = 'told'", encoding="utf-8")
    assert list(vague(tmp_path)) == ["a.py"]


def long_modules(package: Path = PACKAGE) -> list[str]:
    """Modules and texts in C that are long, as `dynamics/recursion`."""
    every = [path for path in (*modules(package), *sorted(package.rglob("*.c"))) if path.name != "__init__.py"]
    return [path.relative_to(package).with_suffix("").as_posix() for path in every if length(path) > LONG]


def of_the_core(package: Path = PACKAGE) -> set[str]:
    """All modules of the core, long or not."""
    return {
        p.relative_to(package).with_suffix("").as_posix() for name in CORE for p in core_files(package, name, "*.py")
    }


def uses(test: Path, module: str, core: bool) -> bool:
    """Whether a test imports the module; beyond the core, also whether it uses it by what the package shows.

    That is another module of its package, the helpers of its tests, a command, or `import lwr_dyn`.
    """
    text = test.read_text(encoding="utf-8")
    if core:
        return f"lwr_dyn.{module.replace('/', '.')}" in imported_by(text)
    package, name = module.split("/")[0], Path(module).name
    return bool(
        re.search(
            rf'\b(lwr_dyn|tests)\.{package}\b|\b(lwr_dyn_command|printed|recorded|refused)\b|"{name}"|^import lwr_dyn$',
            text,
            re.M,
        )
    )


def fault_of(module: str, tests: Path = TESTS, table: Mapping[str, Sequence[str]] = COVERED, core: bool = True) -> str:
    """What the tests of a module lack; empty if nothing."""
    paths = own_tests(module, tests, table)
    missing = [path.relative_to(tests).as_posix() for path in paths if not path.exists()]
    if missing or not paths:
        return f"{missing or f'test_{Path(module).name}.py'} is missing: write it, or name another test in covered.toml"
    using = [path for path in paths if uses(path, module, core)]
    if not using:
        return f"no test of {module} imports the module"
    functions = (node for path in using for node in ast.walk(parsed(path)) if isinstance(node, ast.FunctionDef))
    return "" if any(asserts(node) for node in functions) else f"the tests of {module} assert nothing"


def asserts(function: ast.FunctionDef) -> bool:
    """Whether a function asserts something: by `assert`, a function named assert_..., or `pytest.raises`."""
    calls = [node.func for node in ast.walk(function) if isinstance(node, ast.Call)]
    names = [call.attr if isinstance(call, ast.Attribute) else getattr(call, "id", "") for call in calls]
    by_call = any(name == "raises" or name.startswith("assert_") for name in names)
    return by_call or any(isinstance(node, ast.Assert) for node in ast.walk(function))


def test_a_long_module_has_a_test_that_uses_it_and_asserts():
    core = of_the_core()
    faults = {module: fault_of(module, core=module in core) for module in long_modules()}
    assert {module: fault for module, fault in faults.items() if fault} == {}


def test_the_table_is_in_order():
    assert list(COVERED) == sorted(COVERED)


def test_a_missing_row_and_a_test_without_an_import_or_an_assertion_are_caught(tmp_path):
    package, tests = tmp_path / "lwr_dyn", tmp_path / "tests"
    module, test = package / "control" / "gain.py", tests / "control" / "test_gain.py"
    for path in (module, test):
        path.parent.mkdir(parents=True)
    module.write_text("x = 1\n" * LONG, encoding="utf-8")
    assert long_modules(package) == []
    module.write_text("x = 1\n" * (LONG + 1), encoding="utf-8")
    assert long_modules(package) == ["control/gain"]
    assert "test_gain.py is missing" in fault_of("control/gain", tests, {})
    (tests / "other.py").write_text(
        "from lwr_dyn.control.gain import x\ndef test_x():\n    assert x\n", encoding="utf-8"
    )
    assert fault_of("control/gain", tests, {"control/gain": ["other.py"]}) == ""
    test.write_text("def test_x():\n    assert 1\n", encoding="utf-8")
    assert "imports the module" in fault_of("control/gain", tests, {})
    test.write_text("from lwr_dyn.control.gain import x\ndef test_x():\n    x\n", encoding="utf-8")
    assert "assert nothing" in fault_of("control/gain", tests, {})
    test.write_text("from lwr_dyn.control import gain\ndef test_x():\n    assert gain.x\n", encoding="utf-8")
    assert fault_of("control/gain", tests, {}) == ""
    test.write_text("from lwr_dyn.control import gains\ndef test_x():\n    assert gains.x\n", encoding="utf-8")
    assert "imports the module" in fault_of("control/gain", tests, {})
    assert fault_of("control/gain", tests, {}, core=False) == ""
    test.write_text("from lwr_dyn.model import arm\ndef test_x():\n    assert arm.x\n", encoding="utf-8")
    assert "imports the module" in fault_of("control/gain", tests, {}, core=False)
