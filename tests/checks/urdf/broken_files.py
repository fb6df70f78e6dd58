"""URDFs broken at random, one to four changes each: numbers, names, tags, attributes, whole elements, bytes."""

import random
import re

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.lint import lint_document
from lwr_dyn.checks.urdf.reports import grouped, sarif_record
from tests.checks.urdf.box_arm import BoxArm

NUMBERS = ("0", "-1", "1e308", "-1e308", "1e-320", "nan", "inf", "-inf", "1e15", "1e14", "-1e14", "9" * 400, "1,5",
           "", "x", "1e-29", "0.0000001", "3 4", "1 2 3", "${a}", "\u0661", "--1", "1e", "180", "-90")  # fmt: skip
NAMES = ("l0", "l1", "l2", "l3", "j1", "j2", "j3", "world", "", "空", "a b", "&lt;", "x" * 300)
_NUMBER, _ATTRIBUTE = re.compile(r'(?<=[" ])-?\d[\d.e-]*(?=[" ])'), re.compile(r' (\w+)="[^"]*"')
_ELEMENT, _NAME = re.compile(r"<(\w+)[^<>]*/>"), re.compile(r'(?<=(?:name|link)=")[^"]*')
_BLOCK = re.compile(r"<(link|joint|inertial|visual|geometry)\b.*?</\1>", re.DOTALL)


def broken(seed: int) -> bytes:
    """The arm of boxes with some changes."""
    chance = random.Random(seed)
    text, changes = BoxArm().text(), (_other_number, _other_number, _other_name, _lost, _doubled, _renamed, _moved)
    for _ in range(chance.randint(1, 4)):
        text = chance.choice(changes)(text, chance)
    data = text.encode()
    if chance.random() < 0.08:
        at = chance.randrange(len(data))
        data = data[:at] + bytes([chance.randrange(256)]) + data[at + chance.randrange(3) :]
    return data


def _replaced(pattern: re.Pattern[str], text: str, chance: random.Random, new) -> str:
    places = list(pattern.finditer(text))
    if not places:
        return text
    place = chance.choice(places)
    return text[: place.start()] + new(place) + text[place.end() :]


def _other_number(text: str, chance: random.Random) -> str:
    return _replaced(_NUMBER, text, chance, lambda place: chance.choice(NUMBERS))


def _other_name(text: str, chance: random.Random) -> str:
    return _replaced(_NAME, text, chance, lambda place: chance.choice(NAMES))


def _lost(text: str, chance: random.Random) -> str:
    return _replaced(chance.choice((_ATTRIBUTE, _ELEMENT, _BLOCK)), text, chance, lambda place: "")


def _doubled(text: str, chance: random.Random) -> str:
    return _replaced(chance.choice((_ELEMENT, _BLOCK)), text, chance, lambda place: 2 * place[0])


def _renamed(text: str, chance: random.Random) -> str:
    """A letter of a tag or attribute changed."""
    word = re.compile(r"(?<=[</ ])[a-z]{2,}(?=[ =/>])")
    return _replaced(word, text, chance, lambda place: place[0][:-1] + chance.choice("xyzé"))


def _moved(text: str, chance: random.Random) -> str:
    """A block put somewhere else."""
    places = list(_BLOCK.finditer(text))
    if len(places) < 2:
        return text
    block, other = chance.sample(places, 2)
    return text[: other.start()] + block[0] + text[other.start() :]


def judged(seed: int) -> int:
    """How many findings a broken file gives; grouping and SARIF must take them too."""
    report = lint_document(document_of(broken(seed), f"{seed}.urdf"))
    assert grouped(report.findings) or not report.findings
    assert len(sarif_record([report])["runs"][0]["results"]) == len(report.findings)
    return len(report.findings)
