"""An arm's functions as one JavaScript file: a plain script that defines one name, or an ES module.

Both hold the same object: `robot.NAME(arguments..., out)` fills and returns `out`; without it, it makes one.
"""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, get_args

from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.emit.functions import Emitted, EmittedFunction, TemplateFunction
from lwr_dyn.codegen.emit.javascript import js_function
from lwr_dyn.codegen.emit.javascript_shared import shared_functions
from lwr_dyn.codegen.emit.provenance import provenance_lines
from lwr_dyn.codegen.emit.straight_code import SinCosKind, emitted_code
from lwr_dyn.foundation.errors import OptionError

ScriptForm = Literal["script", "module"]
SCRIPT_FORMS = get_args(ScriptForm)
_ENDINGS: dict[str, ScriptForm] = {".js": "script", ".mjs": "module"}
_USE = {
    "script": "a plain script that defines {0}: const result = {0}.{1};",
    "module": "an ES module: import {0} from this file; const result = {0}.{1};",
}
_TAKEN = (
    "arguments await break case catch class const continue debugger default delete do else enum eval export extends "
    "false finally for function if implements import in instanceof interface let new null package private protected "
    "public return static super switch this throw true try typeof undefined var void while with yield NaN Infinity "
    "name top self window parent status location document history length event origin"
)


def js_files(emitted: EmittedArm, path: Path) -> dict[Path, str]:
    """The file, a module where its name ends in .mjs; raises `OptionError` for an ending, type, name it cannot have."""
    if path.suffix not in _ENDINGS:
        raise OptionError("--out", repr(str(path)), "a path that ends in .js (a plain script) or .mjs (an ES module)")
    if emitted.dtype != "float64":
        raise OptionError("--dtype", repr(emitted.dtype), "float64: numbers of JavaScript are double")
    if emitted.prefix in _TAKEN.split():
        raise OptionError("--prefix", repr(emitted.prefix), "a name that JavaScript and browsers have not taken")
    functions: list[Emitted] = [*(code.function for code in emitted.codes), *emitted.templates]
    form = _ENDINGS[path.suffix]
    head = "\n".join([*provenance_lines(emitted), *_use(emitted, form)])
    return {path: javascript_source(functions, emitted.prefix, form, emitted.kind, head=head)}


def javascript_source(
    functions: Sequence[Emitted],
    name: str,
    form: ScriptForm = "script",
    sincos: SinCosKind = "own",
    is_compact: bool = False,
    head: str = "",
) -> str:
    """The text of a file.

    Parameters
    ----------
    functions : sequence of EmittedFunction, TemplateFunction
        Members of the object, beside `name`, `n` (joints) and `functions`: their arguments, results and units.
    name : str
        Of the object: an identifier.
    form : {"script", "module"}
    sincos : {"own", "libm"}
        The bits of the C code, or Math.sin and Math.cos.
    is_compact : bool
        Without the space that only people need.
    head : str
        Lines of a comment at the top.

    Raises
    ------
    OptionError
        Another form.
    """
    if form not in SCRIPT_FORMS:
        raise OptionError("form", repr(form), ", ".join(SCRIPT_FORMS))
    written = [f for f in functions if isinstance(f, EmittedFunction) or "js" in f.source]
    body = "\n".join(_text(f, sincos) for f in written)
    joints = {a.width for f in written if isinstance(f, EmittedFunction) for a in f.arguments if a.name == "q"}
    facts: dict[str, object] = {"name": name, **({"n": max(joints)} if joints else {})}
    names = [name for f in written for name in _names(f)]
    facts["functions"] = {f.name: _facts(f) for f in written}
    members = [*(f"{key}: {json.dumps(value)}" for key, value in facts.items()), *names]
    inside = f"{shared_functions(body)}{body}return {{\n  {f',{chr(10)}  '.join(members)}\n}};\n"
    text = f'(function () {{\n"use strict";\n{inside}}})();\n'
    if form == "script":
        text = f"var {name} = {text}"
    else:
        exported = ", ".join([*facts, *names])
        text = f"const robot = {text}export default robot;\nexport const {{ {exported} }} = robot;\n"
    return _comment(head) + (_compact(text) if is_compact else text)


def _text(function: Emitted, sincos: SinCosKind) -> str:
    if isinstance(function, EmittedFunction):
        return js_function(emitted_code(function, "libm"), function.name, sincos)
    members = ", ".join(_names(function))
    source = function.written("js", sincos).replace("@NAME@", function.name)
    return f"const {{ {members} }} = (function () {{\n{source.rstrip()}\nreturn {{ {members} }};\n}})();\n"


def _names(function: Emitted) -> list[str]:
    """Members of the object: a template may give several."""
    if isinstance(function, EmittedFunction):
        return [function.name]
    return [name.strip() for name in function.declaration.get("js", function.name).split(",")]


def _facts(function: Emitted) -> dict[str, object]:
    if isinstance(function, TemplateFunction):
        return {"text": function.text}
    arguments = [[a.name, a.width, a.unit] for a in function.arguments]
    return {"arguments": arguments, "width": function.width, "shape": list(function.shape), "unit": function.unit,
            "text": function.text}  # fmt: skip


def _use(emitted: EmittedArm, form: ScriptForm) -> list[str]:
    """How the file is used, by its first function."""
    if not emitted.codes:
        return []
    function = emitted.codes[0].function
    call = f"{function.name}({', '.join(a.name for a in function.arguments)})"
    first = _USE[form].format(emitted.prefix, call)
    return [first, "arrays of numbers; a last argument out is filled and returned, without it a new one is made"]


def _comment(head: str) -> str:
    return "".join(f"// {line}".rstrip() + "\n" for line in head.splitlines())


_STATEMENT = re.compile(r"(v\d+|out\[\d+\]|turned\[\d\]) = ")


def _compact(text: str) -> str:
    """Statements without space and with short numbers; lines that are none stay."""
    return "\n".join(_short(line) for line in text.splitlines()) + "\n"


def _short(line: str) -> str:
    line = line.lstrip()
    if not _STATEMENT.match(line):
        return line
    line = re.sub(r"\b0(\.\d+)", r"\1", re.sub(r"(\d)\.0\b", r"\1", line))
    return line.replace(" ", "")
