"""A finding in a URDF: what is wrong, where, what shows it, how sure that is, and what to write instead."""

from dataclasses import dataclass
from typing import Any, Literal
from xml.sax.saxutils import quoteattr

import numpy as np

from lwr_dyn.checks.urdf.xml_tree import Place, XmlElement
from lwr_dyn.foundation.arrays import Array

FindingSeverity = Literal["error", "warning", "note"]
"""An error is impossible for a body or a joint, a warning most likely wrong, a note worth a look."""
Sureness = Literal["certain", "likely", "possible"]
SEVERITIES: tuple[FindingSeverity, ...] = ("error", "warning", "note")


@dataclass(frozen=True, slots=True)
class UrdfFinding:
    """A suspected fault.

    Parameters
    ----------
    what : str
        One clause with the numbers: "iyy and izz look exchanged".
    why : str
        The figures that show it.
    place : Place
    subject : str
        "link wrist_1", "joint elbow"; empty for the whole file.
    instead : str
        The text to write, or what to do; empty where the file does not tell.
    sure : str
    cause : str
        Groups findings over rules and links: "masses in g". Empty: grouped by code.
    severity : str, optional
        None: that of its rule.
    link : str
        The link that is judged; on one that no joint moves the finding becomes a note.
    code : str
        Name of its rule, filled in when the rule has run.
    """

    what: str
    why: str
    place: Place
    subject: str
    instead: str = ""
    sure: Sureness = "certain"
    cause: str = ""
    severity: FindingSeverity | None = None
    link: str = ""
    code: str = ""

    @property
    def level(self) -> FindingSeverity:
        """Its severity, an error where none is set."""
        return self.severity or "error"

    @property
    def message(self) -> str:
        """What, why and what to write instead, in one line."""
        parts = [f"{self.subject}: {self.what}" if self.subject else self.what, self.why]
        parts += [f"write {self.instead}" if self.instead.startswith("<") else self.instead]
        return "; ".join(part for part in parts if part)

    def record(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "code": self.code, "severity": self.level, "file": self.place.file, "line": self.place.line,
            "column": self.place.column, "subject": self.subject, "what": self.what, "why": self.why,
            "sure": self.sure, "instead": self.instead, "cause": self.cause,
        }  # fmt: skip


def number_text(value: float) -> str:
    """A number in six digits, as short as it can be.

    >>> number_text(0.1 + 0.2), number_text(-0.0)
    ('0.3', '0')
    """
    return f"{value + 0.0:.6g}"


def vector_text(values: Array) -> str:
    """Numbers separated by spaces, as an attribute holds them."""
    return " ".join(number_text(float(v)) for v in values)


def tag_text(element: XmlElement, **changed: str) -> str:
    """The opening tag of an element with some attributes changed or added."""
    cells = {**element.attributes, **changed}
    return f"<{' '.join([element.tag, *(f'{name}={quoteattr(text)}' for name, text in cells.items())])}/>"


def inertia_text(tensor: Array) -> str:
    """The `<inertia>` element of a tensor.

    >>> inertia_text(np.diag([0.1, 0.2, 0.25]))
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.25"/>'
    """
    pairs = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    cells = [f'{name}="{number_text(float(np.asarray(tensor)[at]))}"' for name, at in pairs.items()]
    return f"<inertia {' '.join(cells)}/>"
