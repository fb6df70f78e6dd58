"""What a command found, as a document: a title, a verdict, sections of facts, tables, notes and figures.

Each part stands once, with its value as computed; text, the record of `--json`, its schema, pages and notebooks (the
last two in `lwr_dyn.pages.document`) are written from it. NumPy is not imported.

    Document(title, verdict, sections)
      Section(title, parts)        a card of the page, a paragraph of the text; with a key an object of the record
        Fact(key, value, head)     a line `head: value`, a tile of the page, a key of the record
        Table(title, headings, rows, key=)   aligned rows, a list of objects in the record
        Note(text, when)           a sentence that stands where its condition holds; with a key a list of texts
        PageFigure(draw)           on the page only, drawn when the page is written

What has no `head` is recorded and not shown; what has no `key` is shown and not recorded.

A type of the schema is read off the value; where the value does not show it (None, an empty list, words out of a few)
the part has `kind`: a Python type, `Literal[...]`, a dataclass or a TypedDict, whose fields say what they are by
`Annotated[type, "what it is"]`. Every real number may be null, as `json_text` writes NaN.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, is_dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NotRequired, Union, get_args, get_origin, get_type_hints, is_typeddict

from lwr_dyn.foundation.tables import Heading, Table

ABOUT = (
    "Angles are in rad, lengths in m, torques in N m unless a name says otherwise; null stands for a number that is "
    "unknown or not finite."
)
"""Of every record."""
CAVEATS = "caveats"
"""Key of a record."""
CAVEATS_ARE = "Proven errors that the arm's reading leaves in place, and its numbers that are estimated or assumed."


@dataclass(frozen=True, slots=True)
class Fact:
    """One value; `head`, `unit` and `format` as in `Heading`, which writes it; `says` what it is, in a sentence."""

    key: str | None
    value: Any
    says: str = ""
    head: str = ""
    unit: str = ""
    format: str | Callable[[Any], str] = ""
    kind: Any = None
    """Type in the schema, where the value does not show it."""
    page: bool = False
    """Shown on pages, not in text."""

    @property
    def text(self) -> str:
        """The value with its unit."""
        written = Heading(format=self.format).cell(self.value)
        return f"{written} {self.unit}" if self.unit and written else written


@dataclass(frozen=True, slots=True)
class Note:
    """Sentences that are said where a condition holds; with a key, all that are said are a list in the record."""

    text: str | Sequence[str]
    when: bool = True
    key: str | None = None
    says: str = ""
    page: bool = False
    """Shown on pages, not in text."""
    before: str = ""
    """What stands before each line of text, such as "note: "."""

    @property
    def lines(self) -> tuple[str, ...]:
        """Those that are said."""
        return () if not self.when else (self.text,) if isinstance(self.text, str) else tuple(self.text)


@dataclass(frozen=True, slots=True)
class PageFigure:
    """What only a page shows: `draw()` gives its HTML; style and scripts stand once in the page."""

    draw: Callable[[], str]
    style: str = ""
    scripts: Callable[[], str] | None = None


Part = Fact | Table | Note | PageFigure


@dataclass(frozen=True, slots=True)
class Section:
    """Parts that belong together.

    With a `key` their records are one object of that name. `there` is given where it may be missing: False is null in
    the record (without a key its keys are left out) and nothing elsewhere.
    """

    title: str
    parts: Sequence[Part]
    key: str | None = None
    says: str = ""
    there: bool | None = None
    page: bool = False
    """Shown on pages, not in text."""
    brief: bool = False
    """Shown in notebooks too."""
    own: bool = False
    """Its keys differ from one document of the command to the next: the schema allows them and does not name them."""


@dataclass(frozen=True, slots=True)
class Document:
    """A result for people and programs; see the head of this file.

    >>> weight = Fact("mass", 2.5, "Of the load.", "mass", "kg", ".3g")
    >>> found = Document("Load", "1 load identified", [Section("", [weight, Note("no friction", when=False)])])
    >>> print(found.text())
    1 load identified
    mass: 2.5 kg
    >>> found.record(), found.schema()["properties"]["mass"]["description"]
    ({'mass': 2.5}, 'Of the load.')
    """

    title: str
    verdict: str
    """The result in a sentence: the first line of the text, and below the headline of the page."""
    sections: Sequence[Section]
    command: str = ""
    """What made it, as "lwr-dyn compare"."""
    kind: str = "result"
    """What sort of document it is, in a word, for the head of the page."""
    facts: Sequence[Fact] = field(default_factory=tuple)
    """Tiles of the page, and the first keys of the record."""
    caveats: Sequence[str] | None = None
    """What must be known before the numbers of its arms: the first lines; None where it is of no arm."""

    @property
    def there(self) -> tuple[Section, ...]:
        """The sections that are not missing."""
        return tuple(one for one in self.sections if one.there is not False)

    def text(self) -> str:
        """For the terminal: caveats, the verdict (where there is none the title), then the sections, a line between."""
        head = [*(self.caveats or ()), self.verdict or self.title, *map(_line, filter(_is_shown, self.facts))]
        blocks = ["\n".join(_lines(section)) for section in self.there if not section.page]
        first, *rest = [*filter(None, blocks)] or [""]
        return "\n\n".join(["\n".join(filter(None, [*head, first])), *rest])

    def record(self) -> dict[str, Any]:
        """For `--json`: values as computed."""
        out = _record(self.facts) | ({} if self.caveats is None else {CAVEATS: [*self.caveats]})
        for section in self.sections:
            found = _record(section.parts) if section.there is not False else None
            out |= {section.key: found} if section.key is not None else found or {}
        return out

    def schema(self) -> dict[str, Any]:
        """JSON Schema of the record of `COMMAND --json`.

        Raises `TypeError` for a part whose type neither its value nor its `kind` shows, with its key.
        """
        found = dict(_properties(self.facts))
        if self.caveats is not None:
            found[CAVEATS] = _said(CAVEATS_ARE, type_of(list[str]))
        may: set[str] = set()
        for section in self.sections:
            if section.own:
                continue
            inside = dict(_properties(section.parts))
            may |= {*inside} if section.key is None and section.there is not None else set()
            found |= inside if section.key is None else {section.key: _said(section.says, _missing(section, inside))}
        head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": f"{self.command} --json"}
        others = [section.says for section in self.sections if section.own]
        open_ = {"additionalProperties": _said(others[0], {})} if others else {}
        return {**head, "description": ABOUT, **_object(found, may), **open_}


def _is_shown(part: Part) -> bool:
    """Whether text has it."""
    match part:
        case Fact():
            return bool(part.head and part.text and not part.page)
        case Table():
            return part.is_shown and not part.page
        case Note():
            return not part.page
    return False


def _lines(section: Section) -> Iterator[str]:
    for part in filter(_is_shown, section.parts):
        match part:
            case Fact():
                yield _line(part)
            case Note():
                yield from (part.before + line for line in part.lines)
            case Table():
                yield part.text()


def _line(fact: Fact) -> str:
    return f"{fact.head}: {fact.text}"


def _record(parts: Sequence[Part]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for part in parts:
        match part:
            case Fact(key=str(key)):
                out[key] = part.value
            case Note(key=str(key)):
                out[key] = [*out.get(key, []), *part.lines]
            case Table(columnwise=True):
                out |= part.column_record()
            case Table(key=str(key)):
                out[key] = part.record()
    return out


_PLAIN: dict[Any, dict[str, Any]] = {
    bool: {"type": "boolean"}, int: {"type": "integer"}, float: {"type": ["number", "null"]}, str: {"type": "string"},
    NoneType: {"type": "null"}, Any: {}, dict: {"type": "object"},
}  # fmt: skip


def _missing(section: Section, inside: Mapping[str, Any]) -> dict[str, Any]:
    return _object(inside) if section.there is None else {**_object(inside), "type": ["object", "null"]}


def _properties(parts: Sequence[Part]) -> Iterator[tuple[str, dict[str, Any]]]:
    for part in parts:
        match part:
            case Fact(key=str(key)):
                yield key, _said(part.says, _type(key, part.value, part.kind))
            case Note(key=str(key)):
                yield key, _said(part.says, type_of(list[str]))
            case Table(columnwise=True):
                yield from _columns("", part).items()
            case Table(key=str(key)):
                yield key, _said(part.says, {"type": "array", "items": _object(_columns(f"{key}.", part))})


def _columns(of: str, table: Table) -> dict[str, Any]:
    """The forms of its columns; where they are lists of the record, `kind` is the type of the list."""
    out = {}
    for i, h in enumerate(table.columns):
        if h.key is None:
            continue
        key = h.key or h.head
        value = next((row[i] for row in table.rows if row[i] is not None), None)
        out[key] = _said(h.says, _type(f"{of}{key}", [value] if table.columnwise else value, h.kind))
    return out


def _said(says: str, form: Mapping[str, Any]) -> dict[str, Any]:
    return {**({"description": says} if says else {}), **form}


def _object(properties: Mapping[str, Any], may: Collection[str] = ()) -> dict[str, Any]:
    """An object with these properties; those that `may` be left out are not required."""
    required = [name for name in properties if name not in may]
    return {"type": "object", "properties": properties, "required": required, "additionalProperties": False}


def _type(key: str, value: Any, kind: Any) -> dict[str, Any]:
    if kind is not None:
        return type_of(kind)
    plain = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(plain, Mapping):
        return _object({name: _type(f"{key}.{name}", one, None) for name, one in plain.items()})
    if isinstance(plain, list | tuple):
        if not plain:
            raise TypeError(f"{key}: an empty list does not show its type; give `kind`")
        return {"type": "array", "items": _type(key, next((x for x in plain if x is not None), None), None)}
    if plain is None:
        raise TypeError(f"{key}: None does not show its type; give `kind`")
    return type_of(type(plain))


def type_of(kind: Any) -> dict[str, Any]:
    """The schema of a Python type.

    >>> type_of(list[int] | None)
    {'type': ['array', 'null'], 'items': {'type': 'integer'}}
    """
    origin, inside = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _said(inside[1], type_of(inside[0]))
    if origin in (Union, UnionType):
        return _either(inside)
    if origin is Literal:
        return {"enum": [*inside]}
    if origin in (list, tuple, Sequence):
        return {"type": "array", "items": type_of(inside[0])}
    if origin in (dict, Mapping):
        return {"type": "object", "additionalProperties": type_of(inside[1])}
    if getattr(origin, "__module__", "") == "numpy":
        return {"type": "array", "items": type_of(float)}
    if is_dataclass(kind) or is_typeddict(kind):
        return _record_type(kind)
    return {**_PLAIN[kind]}


def _either(kinds: Sequence[Any]) -> dict[str, Any]:
    """One of several types; None among them is null."""
    one, *more = (type_of(part) for part in kinds if part is not NoneType)
    if more:
        return {"anyOf": [one, *more, *([_PLAIN[NoneType]] if NoneType in kinds else [])]}
    if "enum" in one:
        return {**one, "enum": [*one["enum"], None]}
    types = one.get("type", [])
    types = [types] if isinstance(types, str) else types
    return {**one, "type": [*dict.fromkeys([*types, "null"])]} if types else one


def _record_type(kind: Any) -> dict[str, Any]:
    """The fields of a dataclass or TypedDict; those that are `NotRequired` may be left out."""
    hints = get_type_hints(kind, include_extras=True)
    may = {name for name, form in hints.items() if get_origin(form) is NotRequired}
    forms = {name: get_args(form)[0] if name in may else form for name, form in hints.items()}
    return _object({name: type_of(form) for name, form in forms.items()}, may)
