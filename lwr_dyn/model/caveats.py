"""What stands before an arm's numbers: proven errors that its reading leaves in place, numbers estimated or assumed,
and that the log of a fitted arm contradicts its bodies.

It is decided where an arm is loaded and carried by the arm; each first line, header, page and record takes its sentence
from here.
"""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

GUESSED = ("estimated", "assumed")
"""The kinds of numbers that no source gives."""
KINEMATICS = ("geometry", "position limits", "speed limits")
"""What a pose or a path needs."""
DYNAMICS = (*KINEMATICS, "torque limits", "masses", "centres of mass", "inertias", "rotor inertias", "friction")
"""What torques need."""
ALL = (*DYNAMICS, "gear stiffness", "gear damping")
"""With elastic joints."""
ABSENT_ROTORS = "absent rotors"
"""What advice on gains and sample rates stands on beside them: that no rotor is missing."""

_CONTRADICTED = "contradicted by the log it was fitted to: "
_LEAVES = re.compile(r"leaves (.+) in place, (?:a proven error|proven errors)")
_GUESSED = re.compile(rf"(.+?) ({'|'.join(GUESSED)})(?: (.+))?")


@dataclass(frozen=True, slots=True)
class StandIn:
    """Numbers of one sort that no source gives: which, `estimated` or `assumed`, and how in a few words."""

    what: str
    """One of `ALL`."""
    kind: str
    how: str = ""

    @property
    def words(self) -> str:
        """Kind and how."""
        return f"{self.kind} {self.how}".rstrip()


@dataclass(frozen=True, slots=True)
class Caveats:
    """The proven errors of weight model that a reading leaves in place (ids of errata), and what is estimated."""

    left_in_place: tuple[str, ...] = ()
    estimates: tuple[StandIn, ...] = ()
    likely: tuple[str, ...] = ()
    """Errata that the reading applies though they are likely, not proven."""
    contradicted: str = ""
    """By what the log of a fitted arm contradicts its bodies; empty where it does not."""

    def words(self, used: Collection[str] = ALL) -> str:
        """In a line, of the numbers that are `used`; empty where nothing is to be said.

        >>> solids = [StandIn(what, "estimated", "from drawn solids") for what in ("masses", "inertias")]
        >>> Caveats(("rotor-inertia-power",), tuple(solids)).words(DYNAMICS)
        'leaves rotor-inertia-power in place, a proven error; masses and inertias estimated from drawn solids'
        """
        return "; ".join(filter(None, (self.of_fit, self.of_reading, self.of_numbers(used))))

    @property
    def of_fit(self) -> str:
        """That the bodies of a fitted arm do not meet its log; empty where they do.

        >>> Caveats(contradicted="m_7 is 5.2 sigma off").of_fit
        'contradicted by the log it was fitted to: m_7 is 5.2 sigma off'
        """
        return _CONTRADICTED + self.contradicted if self.contradicted else ""

    @property
    def of_reading(self) -> str:
        """The errors left in place; empty where there are none."""
        errors = "a proven error" if len(self.left_in_place) == 1 else "proven errors"
        return f"leaves {_listed(self.left_in_place)} in place, {errors}" if self.left_in_place else ""

    def of_numbers(self, used: Collection[str] = ALL) -> str:
        """What is estimated or assumed of the numbers that are `used`; empty where nothing is."""
        found: dict[str, list[str]] = {}
        for one in self.estimates:
            if one.what in used:
                found.setdefault(one.words, []).append(one.what)
        return "; ".join(f"{_listed(whats)} {words}" for words, whats in found.items())

    def errata_words(self, errata: Sequence[str]) -> str:
        """Applied errata in words, those that are likely named so.

        >>> Caveats(likely=("b",)).errata_words(("a", "b"))
        'a, b (likely)'
        """
        return ", ".join(f"{name} (likely)" if name in self.likely else name for name in errata) or "none"


ROTOR_OPTION = "--rotor JOINT=VALUE adds it"
"""Where the command has this option."""
ROTOR_RUN = "--rotor JOINT=VALUE of simulate adds it"
"""Of a run that was made before."""
ROTOR_FILE = "name the file that lwr-dyn urdf ROBOT --rotor JOINT=VALUE writes"
"""Where a file names the robot, as in a study."""


def absent_rotors(joints: Sequence[str], n: int, remedy: str = ROTOR_OPTION) -> str:
    """What the absence of rotors means for an arm of `n` joints, and how they are added; empty where none is missing.

    >>> absent_rotors(("A2", "A3"), 6)
    'no rotor inertia of A2 and A3 given (--rotor JOINT=VALUE adds it): gears make a real arm heavier at its joints'
    """
    if not joints:
        return ""
    which = "" if len(joints) == n else f" of {_listed(joints)}"
    return f"no rotor inertia{which} given ({remedy}): gears make a real arm heavier at its joints"


def caveats_of_words(words: str) -> Caveats:
    """What `Caveats.words` wrote; a clause of another form is left out.

    >>> text = "leaves a, b and c in place, proven errors; masses and friction assumed"
    >>> caveats_of_words(text).words() == text
    True
    """
    left: list[str] = []
    estimates, contradicted = [], ""
    for clause in words.split("; "):
        if clause.startswith(_CONTRADICTED):
            contradicted = clause.removeprefix(_CONTRADICTED)
        elif found := _LEAVES.fullmatch(clause):
            left += _names(found[1])
        elif found := _GUESSED.fullmatch(clause):
            estimates += [StandIn(what, found[2], found[3] or "") for what in _names(found[1]) if what in ALL]
    return Caveats(tuple(left), tuple(estimates), contradicted=contradicted)


def _listed(names: Sequence[str]) -> str:
    """a, b and c."""
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _names(listed: str) -> list[str]:
    return re.split(r", | and ", listed)
