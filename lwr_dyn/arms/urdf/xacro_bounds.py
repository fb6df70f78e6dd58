"""What a foreign xacro file may cost: xacro's own loops, patterns and files within bounds, its expressions by ours.

xacro clones bodies, moves children one by one, searches folders and splits texts without an end in sight; what stands
here in place of its functions counts that before it is done, together with the values of `Expressions`.
"""

import math
import os
import re
import stat
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from lwr_dyn.arms.urdf.xacro_expressions import FUNCTIONS, ExpressionError, Expressions

LARGEST_FILE, LARGEST_YAML = 1_000_000, 100_000
"""[bytes] Of a file of macros, with those that it includes twice as much; of a YAML file."""
_BYTE, _YAML_BYTE, _FILE, _NODE, _CALL, _FIND, _LETTER = 5, 50, 20000, 60, 1000, 1000, 10
_MOVE = 20
"""Siblings that are passed in the time of one count."""
_LONGEST = 10_000
_OWN = (
    "check_attrs", "eval_extension", "eval_text", "grab_macro", "grab_property", "is_valid_name", "parse",
    "remove_previous_comments", "replace_node", "resolve_macro",
)  # fmt: skip
"""Functions of xacro that `_Bounded` has under the same name."""
_QUOTED = r"""\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"])+|"""
_MACRO_ARGUMENT = re.compile(r"^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?(" + _QUOTED + r")(?:\s+|$)(.*)")
"""xacro's pattern of a parameter without the two repetitions inside each other, over which it can brood for years."""


def stand_ins(xacro: Any, substitution_args: Any, parse: Callable[..., Any]) -> list[tuple[Any, str, Any]]:
    """Module, name, what stands there while one file is expanded; `parse` reads its files."""
    bounded = _Bounded(xacro, substitution_args, parse)
    return [
        (xacro, "safe_eval", bounded.expressions),
        (xacro, "re_macro_arg", _MACRO_ARGUMENT),
        (xacro, "glob", SimpleNamespace(glob=bounded.glob)),
        (substitution_args, "_eval", bounded.eval),
        *((xacro, name, getattr(bounded, name)) for name in _OWN),
    ]


def _nodes(element: Any) -> int:
    """Elements, texts and comments from here on."""
    waiting, count = [element], 0
    while waiting:
        count += 1
        waiting += waiting.pop().childNodes
    return count


class _Bounded:
    """Functions of xacro, named as these, that count before they work."""

    def __init__(self, xacro: Any, substitution_args: Any, parse: Callable[..., Any]) -> None:
        self.expressions = Expressions({"load_yaml": self.load_yaml})
        self.count = self.expressions.count
        self.xacro, self.arguments, self.inner_parse = xacro, substitution_args, parse
        self.plain = SimpleNamespace(**vars(xacro))
        self.blocks: dict[str, int] = {}

    def _file(self, path: str, largest: int, cost: int) -> None:
        """Refuse pipes, devices and large files; one that is not there is left to xacro."""
        try:
            found = os.stat(path)
        except (OSError, ValueError):
            return
        if not stat.S_ISREG(found.st_mode):
            raise ExpressionError(f"{path}, which is no regular file")
        if found.st_size > largest:
            raise ExpressionError(f"{path} of {found.st_size} bytes, above {largest}")
        self.count(_FILE + cost * found.st_size)

    def load_yaml(self, filename: str) -> Any:
        self._file(self.xacro.abs_filename_spec(filename), LARGEST_YAML, _YAML_BYTE)
        return self.plain.load_yaml(filename)

    def parse(self, given: Any, filename: str | None = None) -> Any:
        if given is None:
            self._file(os.path.join(self.xacro.root_dir, str(filename)), LARGEST_FILE, _BYTE)
        return self.inner_parse(given, filename)

    def glob(self, pattern: str) -> list[str]:
        """Names of one folder; xacro would search any disk from its root."""
        if re.search(r"[*?[]", os.path.dirname(pattern)):
            raise ExpressionError(f"{pattern}, with wildcards in its folders")
        self.count(_FIND)
        found: list[str] = self.plain.glob.glob(pattern)
        return found

    def eval_text(self, text: Any, symbols: Any) -> Any:
        if isinstance(text, str):  # each part is cut off the whole rest
            self.count(len(text) * text.count("$") >> 10)
        out = self.plain.eval_text(text, symbols)
        self.count(len(out) if isinstance(out, str) else 1)
        return out

    def eval_extension(self, text: str) -> Any:
        if text.count("$(") > 1 or len(text) > _LONGEST:
            raise ExpressionError("a substitution that makes others")
        found = self.plain.eval_extension(text)
        self.count(_FIND + _LETTER * len(found))
        return found

    def eval(self, text: str, context: Any) -> str:
        """`$(eval ...)`: the arguments by name, numbers as numbers; functions first, as in roslaunch."""
        known = self.arguments._eval_dict
        given = {name: self.arguments.convert_value(value, "auto") for name, value in context["arg"].items()}
        names: dict[str, Any] = {**given, **FUNCTIONS, **{x: y for x, y in vars(math).items() if isinstance(y, float)}}
        names |= {"true": True, "false": False, "arg": lambda name: given[name]}
        names |= {name: known[name] for name in ("env", "optenv")} | {"find": self.arguments._eval_find}
        return str(self.expressions(text, names))

    def is_valid_name(self, name: str) -> bool:
        return len(name) < _LONGEST and bool(self.plain.is_valid_name(name))

    def check_attrs(self, element: Any, needed: Any, optional: Any) -> Any:
        found = self.plain.check_attrs(element, needed, optional)
        if element.tagName == "xacro:insert_block":
            self.count(_NODE * self.blocks.get(found[0], 0))
        return found

    def grab_property(self, element: Any, table: Any) -> None:
        name, size = element.getAttribute("name"), _nodes(element) if element.childNodes else 0
        if size:
            self.count(size)
            name = str(self.eval_text(name, table))
            self.blocks[name] = max(size, self.blocks.get(name, 0))
        self.plain.grab_property(element, table)

    def grab_macro(self, element: Any, macros: Any) -> None:
        length = len(element.getAttribute("params"))
        if length > _LONGEST:
            raise ExpressionError(f"parameters of {length} characters")
        self.count(length * length // 1000)
        self.plain.grab_macro(element, macros)

    def resolve_macro(self, name: str, macros: Any, symbols: Any) -> Any:
        """A macro that is called: its body will be cloned."""
        found = self.plain.resolve_macro(name, macros, symbols)
        self.count(_CALL + _NODE * _nodes(found[2].body))
        return found

    def replace_node(self, node: Any, by: Any, content_only: bool = False) -> None:
        """Each child that is moved is looked for among its new siblings."""
        moved = sum(len(x.childNodes) for x in (by if isinstance(by, list) else [by]) if x is not None)
        self.count((1 + moved) * (len(node.parentNode.childNodes) + moved) // _MOVE)
        if node.tagName == "xacro:insert_block":
            self.count(_NODE * _nodes(by))
        self.plain.replace_node(node, by, content_only)

    def remove_previous_comments(self, node: Any) -> None:
        before, run = node.previousSibling, 1
        while before is not None and before.nodeType in (before.TEXT_NODE, before.COMMENT_NODE):
            before, run = before.previousSibling, run + 1
        self.count(run * len(node.parentNode.childNodes) // _MOVE)
        self.plain.remove_previous_comments(node)
