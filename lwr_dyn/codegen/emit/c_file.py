"""A file of C99 and its header: provenance, guards, the functions, a self-test behind #ifdef."""

from collections.abc import Iterator
from pathlib import Path

from lwr_dyn.codegen.emit.c_self_test import self_test
from lwr_dyn.codegen.emit.c_source import C_TYPES, c_function, declaration, needs_library, shared_functions
from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.emit.functions import TemplateFunction
from lwr_dyn.codegen.emit.identifiers import identifier
from lwr_dyn.codegen.emit.provenance import provenance_lines, wrapped
from lwr_dyn.codegen.emit.straight_code import EmittedCode
from lwr_dyn.foundation.errors import OptionError

_FAST_MATH = """\
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST)
#error "compile without -ffast-math, -Ofast, /fp:fast: they change results, and break the sine and cosine of this file"
#endif
"""
_PRECISION = """\
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "compile for arithmetic in the type itself (-mfpmath=sse): sine and cosine here rely on its rounding"
#endif
"""
_UNCONTRACTED = """\
#if defined(__clang__) && defined(__STDC__)
#pragma STDC FP_CONTRACT OFF
#endif
"""
"""clang, unlike gcc with -std=c99, otherwise contracts a product and a sum of one statement."""


def c_files(emitted: EmittedArm, path: Path) -> dict[Path, str]:
    """FILE.c and FILE.h; raises `OptionError` for a path with another ending, or that #include cannot name."""
    if path.suffix != ".c":
        raise OptionError("--out", repr(str(path)), "a path that ends in .c")
    header = path.with_suffix(".h")
    if any(c in header.name for c in '"\\') or not header.name.isprintable():
        raise OptionError("--out", repr(header.name), "a file name without quotes, backslashes, control characters")
    return {path: c_text(emitted, header.name), header: header_text(emitted, header.stem)}


def c_text(emitted: EmittedArm, header: str) -> str:
    """The source, which includes the header of that name."""
    library = emitted.templates or any(needs_library(code) for code in emitted.codes)
    parts = [
        comment(provenance_lines(emitted)),
        f'#include "{header}"\n' + ("#include <math.h>\n" if library else "") + "#include <float.h>\n",
        _FAST_MATH + (_PRECISION if emitted.kind == "own" else ""),
        *filter(None, [shared_functions(emitted.codes)]),
        *(c_function(code, emitted.name_of(code.function.name), restrict_of(emitted)) for code in emitted.codes),
        *([_UNCONTRACTED] if emitted.templates else []),
        *(filled(template.written("c", emitted.kind), template, emitted) for template in emitted.templates),
        self_test(emitted),
    ]
    return "\n".join(parts)


def header_text(emitted: EmittedArm, stem: str) -> str:
    """The header: a declaration of each function with its units; C++ takes it too."""
    guard = "_".join([*dict.fromkeys((emitted.prefix, identifier(stem))), "h"]).upper()
    restrict = restrict_of(emitted)
    parts = [
        comment(provenance_lines(emitted)),
        f"#ifndef {guard}\n#define {guard}\n",
        f"#if defined(__cplusplus) || defined(_MSC_VER)\n#define {restrict}\n#else",
        f"#define {restrict} restrict\n#endif\n",
        '#ifdef __cplusplus\nextern "C" {\n#endif\n',
        *_declarations(emitted),
        "#ifdef __cplusplus\n}\n#endif\n",
        "#endif\n",
    ]
    return "\n".join(parts)


def comment(lines: list[str]) -> str:
    """Lines as a comment of C."""
    return "\n".join(["/*", *(f" * {line}" for line in lines), " */", ""])


def filled(text: str, template: TemplateFunction, emitted: EmittedArm) -> str:
    """A text of a template with its names."""
    number, _ = C_TYPES[emitted.dtype]
    return text.replace("@NAME@", emitted.name_of(template.name)).replace("@NUMBER@", number)


def restrict_of(emitted: EmittedArm) -> str:
    """The macro that stands for C's restrict, which C++ does not have."""
    return f"{emitted.prefix.upper()}_RESTRICT"


def _declarations(emitted: EmittedArm) -> Iterator[str]:
    for code in emitted.codes:
        name = emitted.name_of(code.function.name)
        yield comment(_described(code)) + f"{declaration(code, name, restrict_of(emitted))};\n"
    for template in emitted.templates:
        lines = [x for line in template.text.splitlines() for x in wrapped(line)]
        yield comment(lines) + f"{filled(template.declaration['c'], template, emitted)};\n"


def _described(code: EmittedCode) -> list[str]:
    function = code.function
    where = "out must not overlap an argument" if code.stores_early else "out may be an argument"
    texts = [
        f"{function.text}; {code.operations} operations, {where}",
        *(f"{a.name} [{a.unit}]" for a in function.arguments),
        f"out [{function.unit}]",
    ]
    return [line for text in texts for line in wrapped(text)]
