"""URDFs broken at random: numbers, names, tags, attributes, lines and pieces of the text, bytes."""

import random
import re

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.lint import lint_document
from lwr_dyn.checks.urdf.reports import grouped, sarif_record
from tests.checks.urdf.box_arm import BoxArm
from tests.hostile.changes import changed, flipped

_ELEMENT, _ATTRIBUTE = re.compile(r"<(\w+)[^<>]*/>"), re.compile(r' (\w+)="[^"]*"')
_BLOCK = re.compile(r"<(link|joint|inertial|visual|geometry)\b.*?</\1>", re.DOTALL)


def broken(seed: int) -> bytes:
    """The arm of boxes with some changes; in half of them a whole element is lost, doubled or put somewhere else."""
    chance = random.Random(seed)
    text = changed(BoxArm().text(), chance)
    places = list(chance.choice((_ELEMENT, _ATTRIBUTE, _BLOCK, _BLOCK)).finditer(text))
    if places and chance.random() < 0.5:
        one, other = chance.choice(places), chance.choice(places)
        new = chance.choice(("", 2 * one[0], other[0] + one[0], other[0]))
        text = text[: one.start()] + new + text[one.end() :]
    data = text.encode("utf-8", "surrogatepass")
    return flipped(data, chance) if chance.random() < 0.08 else data


def judged(seed: int) -> int:
    """How many findings a broken file gives; grouping and SARIF must take them too."""
    report = lint_document(document_of(broken(seed), f"{seed}.urdf"))
    assert grouped(report.findings) or not report.findings
    assert len(sarif_record([report])["runs"][0]["results"]) == len(report.findings)
    return len(report.findings)
