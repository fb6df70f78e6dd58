"""What the name at a place in a file refers to, with its declaration, type and value as text for an editor."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache
from typing import Any, Literal

from lwr_dyn.krl.checks.type_check import type_in
from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Declaration, EnumType, StructType
from lwr_dyn.krl.language.lexer import LineError, Token, tokens_of
from lwr_dyn.krl.language.unparse import expression_text, statement_text
from lwr_dyn.krl.names.known_names import Type
from lwr_dyn.krl.project.program import Program, Scope, scope_of
from lwr_dyn.krl.project.project import DeclaredName, ModuleFile, SymbolTable

Meaning = Literal["variable", "routine", "type", "component", "constant", "label"]


@dataclass(frozen=True, slots=True, eq=False)
class Referent:
    """What a name means; `declared` where the project declares it, None for a name of every controller."""

    meaning: Meaning
    name: str
    owner: str = ""
    """Of a component or a constant, its type in capitals."""
    declared: DeclaredName | Routine | None = None
    position: SourcePosition | None = None
    node: Any = None
    """The expression that stands there: a name, or one with its index."""

    @property
    def key(self) -> tuple[object, ...]:
        """Equal for two places that mean the same."""
        place = self.position if self.owner == "" else None
        return (self.meaning, self.owner, self.name.upper() if place is None else place)


@dataclass(frozen=True, slots=True, eq=False)
class LineContext:
    """A line of a file of a program, with the names that are seen there."""

    program: Program
    file: ModuleFile
    line: int
    scope: Scope

    @property
    def statement(self) -> s.Statement | None:
        """Of the line."""
        return self.file.file.lines[self.line].statement

    @property
    def text(self) -> str:
        """Of the line."""
        return self.file.file.lines[self.line].shown


def line_context(program: Program, file: ModuleFile, line: int, scopes: dict[int, Scope] | None = None) -> LineContext:
    """A line with its scope; `scopes` keeps those of the routines."""
    kept = {} if scopes is None else scopes
    routine = next((r for r in file.outline.routines if r.first - 1 <= line <= max(r.last, r.first)), None)
    if id(routine) not in kept:
        plain = Scope(program, SymbolTable(), file.file, [])
        kept[id(routine)] = plain if routine is None else scope_of(program, routine, [])
    return LineContext(program, file, line, kept[id(routine)])


def referent_at(context: LineContext, column: int) -> tuple[Token, Referent] | None:
    """The name that stands at a column (from 1) and what it refers to; None where no name stands."""
    tokens = _tokens(context.text)
    i = next((k for k, t in enumerate(tokens) if t.column <= column <= t.column + len(t.text)), None)
    if i is not None and i + 1 < len(tokens) and tokens[i].kind not in _NAMES and tokens[i + 1].column == column:
        i += 1
    if i is None or tokens[i].kind not in _NAMES:
        return None
    found = _referent(context, tokens, i)
    return None if found is None else (tokens[i], found)


def named_in(context: LineContext, name: str | None = None) -> Iterator[tuple[Token, Referent | None]]:
    """All names of a line, or those that are spelt so (in any case), with what they refer to, None if nothing known."""
    tokens = _tokens(context.text)
    for i, token in enumerate(tokens):
        if token.kind in _NAMES and (name is None or token.text.lstrip("# \t").upper() == name.upper()):
            yield token, _referent(context, tokens, i)


def unresolved(program: Program, file: ModuleFile, wanted: Referent) -> Iterator[int]:
    """The lines (from 0) with a component of the wanted one's name, of a structure that is not known."""
    scopes: dict[int, Scope] = {}
    for i, line in enumerate(file.file.lines):
        if wanted.meaning != "component" or line.statement is None or wanted.name.upper() not in line.shown.upper():
            continue
        context, tokens = line_context(program, file, i, scopes), _tokens(line.shown)
        for k, token in enumerate(tokens):
            named = token.kind == "NAME" and token.text.upper() == wanted.name.upper()
            member = k and (tokens[k - 1].kind in ("_DOT", "BRACE") or _is_item(context.statement, token))
            if named and member and _referent(context, tokens, k) is None:
                yield i


def _is_item(statement: s.Statement | None, token: Token) -> bool:
    return any(isinstance(x, e.Item) and x.column == token.column for x in _nodes(statement))


def name_column(token: Token) -> int:
    """The column (from 1) at which the name in a token begins: behind the # of a constant.

    >>> name_column(Token("ENUMERATION", "# OPEN", 5))
    7
    """
    return token.column + len(token.text) - len(token.text.lstrip("# \t"))


_NAMES = ("NAME", "ENUMERATION")


def _tokens(text: str) -> list[Token]:
    if text.lstrip().startswith("&"):
        return []
    try:
        return tokens_of(text)[0]
    except LineError:
        return []


def _referent(context: LineContext, tokens: list[Token], i: int) -> Referent | None:
    token, statement = tokens[i], context.statement
    if token.kind == "ENUMERATION":
        return _constant(context, token)
    if isinstance(statement, StructType | EnumType) and token.column > statement.column:
        return _member(context, statement, token)
    if isinstance(statement, Declaration) and token.column < statement.names[0].column:
        return _type(context.scope, token, None)
    here = (x for x in _nodes(statement) if getattr(x, "column", 0) == token.column)
    node = next((x for x in here if str(getattr(x, "name", "")).upper() == token.text.upper()), None)
    if isinstance(node, e.Component):
        return _component(context.scope, type_in(context.scope.silent(), node.of), node.name, node)
    if isinstance(node, e.Item):
        owner = _owner_of_item(context.scope, statement, node)
        return None if owner is None else _component(context.scope, owner, node.name, node)
    if isinstance(statement, s.Jump) or (isinstance(statement, s.Label) and i == 0):
        return _label(context, token)
    called = isinstance(node, e.FunctionCall) or (i + 1 < len(tokens) and tokens[i + 1].kind == "_LPAR")
    order = (_routine, _variable, _type) if called else (_variable, _routine, _type)
    # `T[3]` where the name is the T in it
    within = next((x for x in _nodes(statement) if isinstance(x, e.Index) and x.of is node), node)
    return next((x for x in (find(context.scope, token, within) for find in order) if x is not None), None)


def _nodes(x: Any) -> list[Any]:
    """A record and all records within, the inner ones first."""
    if isinstance(x, tuple):
        return [node for part in x for node in _nodes(part)]
    kind: type = type(x)
    names = _field_names(kind)
    return [node for name in names for node in _nodes(getattr(x, name))] + [x] if names else []


@cache
def _field_names(kind: type) -> tuple[str, ...]:
    return tuple(one.name for one in fields(kind)) if is_dataclass(kind) else ()


def _variable(scope: Scope, token: Token, node: Any) -> Referent | None:
    key = token.text.upper()
    found = next((x.variables[key] for x in scope.tables if key in x.variables), None)
    if found is not None:
        return Referent("variable", found.name, declared=found, position=found.position, node=node)
    return None if scope.variable(token.text) is None else Referent("variable", token.text, node=node)


def _routine(scope: Scope, token: Token, node: Any) -> Referent | None:
    routine = scope.program.routine(token.text)
    if routine is not None:
        position = routine.file.position(routine.first - 1, routine.head.column)
        return Referent("routine", routine.head.name, declared=routine, position=position, node=node)
    return Referent("routine", token.text, node=node) if isinstance(node, e.FunctionCall) else None


def _type(scope: Scope, token: Token, node: Any) -> Referent | None:
    key = token.text.upper()
    found = next((x.types[key] for x in scope.tables if key in x.types), None)
    if found is not None:
        return Referent("type", found.name, declared=found, position=found.position)
    return Referent("type", token.text) if scope.is_type(key) else None


def _member(context: LineContext, x: StructType | EnumType, token: Token) -> Referent | None:
    """A component or a constant where its type declares it, or the type of a component."""
    meaning: Meaning = "component" if isinstance(x, StructType) else "constant"
    if isinstance(x, StructType):
        declarators = [d for _, names in x.members for d in names]
        if not any(d.column == token.column for d in declarators):
            sizes = any(isinstance(n, e.Name) and n.column == token.column for n in _nodes(x))
            return (_variable if sizes else _type)(context.scope, token, None)
    position = context.file.file.position(context.line, token.column)
    return Referent(meaning, token.text, x.name.upper(), position=position)


def _constant(context: LineContext, token: Token) -> Referent:
    name = token.text[1:].lstrip()
    enums = (pair for table in context.scope.tables for pair in table.enums.items())
    owner = next((enum for enum, members in enums if name.upper() in members), "")
    return Referent("constant", name, owner or "#", position=_member_position(context.scope, owner, name))


def _component(scope: Scope, owner: Type, name: str, node: Any) -> Referent | None:
    components = scope.structure(owner.name)
    if components is None or name.upper() not in components:
        return None
    return Referent("component", name, owner.name, position=_member_position(scope, owner.name, name), node=node)


def _member_position(scope: Scope, owner: str, name: str) -> SourcePosition | None:
    """Where the type of a component or constant declares it."""
    of_type = next((x.types[owner].position for x in scope.tables if owner in x.types), None)
    if of_type is None:
        return None
    line = scope.program.project.file(of_type.file).file.lines[of_type.line - 1]
    members = (t for t in _tokens(line.shown) if t.kind == "NAME" and t.column > of_type.column)
    columns = (t.column for t in members if t.text.upper() == name.upper())
    return replace(of_type, column=next(columns, of_type.column))


def _label(context: LineContext, token: Token) -> Referent | None:
    routine = context.scope.routine
    at = None if routine is None else routine.labels.get(token.text.upper())
    return None if at is None else Referent("label", token.text, position=context.file.file.position(at))


def _owner_of_item(scope: Scope, statement: s.Statement | None, item: e.Item) -> Type | None:
    """The type of the structure whose component an item of `{X 1, Y 2}` gives."""
    pairs: list[tuple[Any, Type]] = []
    if isinstance(statement, Declaration):
        pairs = [(d.value, Type((statement.type or "?").upper())) for d in statement.names]
    elif isinstance(statement, s.Assign):
        pairs = [(statement.value, type_in(scope.silent(), statement.target))]
    pairs += [(x, Type("?")) for x in _nodes(statement) if isinstance(x, e.Aggregate)]
    return next((found for x, kind in pairs if (found := _owner_within(scope, x, kind, item)) is not None), None)


def _owner_within(scope: Scope, x: Any, kind: Type, item: e.Item) -> Type | None:
    if not isinstance(x, e.Aggregate):
        return None
    own = Type(x.type.upper()) if x.type is not None else kind
    if own.name == "?":
        own = type_in(scope.silent(), x)
    components = scope.structure(own.name) or {}
    for one in x.items:
        if one is item:
            return own
        inner = components.get(one.name.upper())
        found = None if inner is None else _owner_within(scope, one.value, inner.element, item)
        if found is not None:
            return found
    return None


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
    match found.meaning:
        case "label":
            return [f"{found.name}:"]
        case "constant":
            return _constant_lines(context, found)
        case "component":
            components = context.scope.structure(found.owner) or {}
            return [f"{components[found.name.upper()]} {found.name} of {found.owner}"]
        case "type":
            return _type_lines(context, found)
        case "routine":
            return [_known(context, found.name)]
        case "variable":
            return [_variable_line(context, found)]


def _variable_line(context: LineContext, found: Referent) -> str:
    declared = found.declared
    if declared is None and context.scope.known.text(found.name) is not None:
        return _known(context, found.name)
    kind = context.scope.variable(found.name)
    text = "" if kind is None or kind.name == "?" else f"{kind} "
    is_global, const = (declared.is_global, declared.const) if isinstance(declared, DeclaredName) else (False, False)
    return f"{'GLOBAL ' * is_global}DECL {'CONST ' * const}{text}{found.name}"


def _constant_lines(context: LineContext, found: Referent) -> list[str]:
    """The enumerations that have it: the project's, or the first known ones."""
    own, known = context.scope.enum(found.owner), context.scope.known.enums
    enums = {name: x for name, x in known.items() if found.name.upper() in x} if own is None else {found.owner: own}
    lines = [f"ENUM {name} {', '.join(sorted(members))}" for name, members in enums.items()]
    return lines[:MOST_VALUES] or [f"#{found.name}"]


def _type_lines(context: LineContext, found: Referent) -> list[str]:
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
    more = len(lines) - MOST_VALUES + 1
    return lines if more <= 1 else [*lines[: MOST_VALUES - 1], f"; and {more} more"]


def _assigned(context: LineContext, found: Referent) -> Iterator[str]:
    if found.position is None or found.position.file not in context.program.project.homes:
        return
    node = found.node
    wanted = node if isinstance(node, e.Index) and all(isinstance(i, e.Integer) for i in node.indices) else None
    for _, x in context.program.project.file(found.position.file).outline.data:
        named = isinstance(x, s.Assign) and e.root_name(x.target) == found.name.upper()
        if isinstance(x, s.Assign) and named and (wanted is None or _starts_with(x.target, wanted)):
            yield statement_text(x)


def _starts_with(target: e.Reference, wanted: e.Index) -> bool:
    """Whether the target is the element, or a part of it."""
    x: e.Reference = target
    while not isinstance(x, e.Name):
        if isinstance(x, e.Index) and isinstance(x.of, e.Name):
            return x.indices[: len(wanted.indices)] == wanted.indices[: len(x.indices)]
        x = x.of
    return False
