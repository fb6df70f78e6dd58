"""A name's declaration, type and value as text for an editor, in Markdown."""

from __future__ import annotations

from collections.abc import Iterator

from lwr_dyn.krl.editor.referents import LineContext, Referent
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.unparse import expression_text, statement_text
from lwr_dyn.krl.project.symbols import DeclaredName

MOST_VALUES = 8
"""Lines of values that are shown of one variable."""


def hover_text(context: LineContext, found: Referent) -> str:
    """What is known of a name: how it is declared, its values in the `.dat`, and where it stands or who brings it."""
    code = [*_declaration(context, found), *_values(context, found)]
    if found.position is not None:
        where = f"{found.position.file}, line {found.position.line}"
    else:
        where = str(context.scope.known.origins.get((found.owner or found.name).upper(), ""))
    return "```krl\n" + "\n".join(code) + "\n```" + (f"\n\n{where}" if where else "")


def _declaration(context: LineContext, found: Referent) -> list[str]:
    if isinstance(found.declared, Routine):
        return [statement_text(found.declared.head)]
    if found.meaning in ("component", "constant", "label"):
        return _part(context, found)
    if found.meaning == "routine":
        return [_known(context, found.name)]
    if found.meaning == "type":
        return _type(context, found)
    if found.declared is None and context.scope.known.text(found.name) is not None:
        return [_known(context, found.name)]
    kind = context.scope.variable(found.name)
    text = "" if kind is None or kind.name == "?" else f"{kind} "
    mark = "CONST " if isinstance(found.declared, DeclaredName) and found.declared.const else ""
    shared = "GLOBAL " if isinstance(found.declared, DeclaredName) and found.declared.is_global else ""
    return [f"{shared}DECL {mark}{text}{found.name}"]


def _part(context: LineContext, found: Referent) -> list[str]:
    if found.meaning == "label":
        return [f"{found.name}:"]
    if found.meaning == "constant":
        return _constant(context, found)
    components = context.scope.structure(found.owner) or {}
    return [f"{components[found.name.upper()]} {found.name} of {found.owner}"]


def _constant(context: LineContext, found: Referent) -> list[str]:
    """The enumerations that have it: the project's, or the first known ones."""
    own, known = context.scope.enum(found.owner), context.scope.known.enums
    enums = {name: x for name, x in known.items() if found.name.upper() in x} if own is None else {found.owner: own}
    lines = [f"ENUM {name} {', '.join(sorted(members))}" for name, members in enums.items()]
    return lines[:MOST_VALUES] or [f"#{found.name}"]


def _type(context: LineContext, found: Referent) -> list[str]:
    key = found.name.upper()
    components, members = context.scope.structure(key), context.scope.enum(key)
    if components is not None:
        return [f"STRUC {found.name} {', '.join(f'{kind} {name}' for name, kind in components.items())}"]
    return [found.name if members is None else f"ENUM {found.name} {', '.join(sorted(members))}"]


def _known(context: LineContext, name: str) -> str:
    """The declaration of a name that comes with the controller or an option."""
    text, origin = context.scope.known.text(name), context.scope.known.origins.get(name.upper())
    return f"{name} ( )" if text is None else text.removesuffix(f" ({origin})")


def _values(context: LineContext, found: Referent) -> list[str]:
    """The value of its declaration, and what the `.dat` assigns to it or to its elements."""
    declared = found.declared
    if not isinstance(declared, DeclaredName):
        return []
    own = [] if declared.declarator is None or declared.declarator.value is None else [declared.declarator.value]
    lines = [f"{declared.name} = {expression_text(x)}" for x in own] + list(_assigned(context, found))
    return (
        lines
        if len(lines) <= MOST_VALUES
        else [*lines[: MOST_VALUES - 1], f"; and {len(lines) - MOST_VALUES + 1} more"]
    )


def _assigned(context: LineContext, found: Referent) -> Iterator[str]:
    if found.position is None or found.position.file not in context.program.project.homes:
        return
    wanted = found.node if isinstance(found.node, e.Index) and _is_constant(found.node) else None
    for _, x in context.program.project.file(found.position.file).outline.data:
        named = isinstance(x, s.Assign) and _root(x.target).upper() == found.name.upper()
        if isinstance(x, s.Assign) and named and (wanted is None or _starts_with(x.target, wanted)):
            yield statement_text(x)


def _is_constant(x: e.Index) -> bool:
    return all(isinstance(i, e.Integer) for i in x.indices)


def _root(x: e.Reference) -> str:
    while not isinstance(x, e.Name):
        x = x.of
    return x.name


def _starts_with(target: e.Reference, wanted: e.Index) -> bool:
    """Whether the target is the element, or a part of it."""
    x: e.Reference = target
    while not isinstance(x, e.Name):
        if isinstance(x, e.Index) and isinstance(x.of, e.Name):
            return x.indices[: len(wanted.indices)] == wanted.indices[: len(x.indices)]
        x = x.of
    return False
