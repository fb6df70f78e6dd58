"""Every name that a script imports from the package or the tests is there, whether or not a test runs the script."""

import ast
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
FILES = {str(path.relative_to(SCRIPTS)): path for path in sorted(SCRIPTS.rglob("*.py"))}


@pytest.mark.parametrize("name", FILES)
def test_what_a_script_imports_is_there(name):
    tree = ast.parse(FILES[name].read_text(encoding="utf-8"))
    for node in (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module):
        if node.module.split(".")[0] in ("lwr_dyn", "tests"):
            module = import_module(node.module)
            for each in node.names:
                assert hasattr(module, each.name) or find_spec(f"{node.module}.{each.name}"), (node.module, each.name)
