"""Rules of two links of one shape: left and right, or the same part again, turned by quarters or mirrored.

A turn or mirror image that takes one centre of mass to the other takes one tensor to the other as well.
"""

from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations, permutations, product
from typing import NamedTuple

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument, UrdfFinding, inertia_text
from lwr_dyn.checks.urdf.judgement import judgements
from lwr_dyn.checks.urdf.undoings import MassPoint, as_written, log_distance, spread_ratios
from lwr_dyn.foundation.arrays import Array

SAME_MASS = 1e-3
"""Relative."""
SAME_CENTRE, SAME_TENSOR = 2e-3, 0.02
"""Of the centre's distance from the frame; of the largest moment."""
SAME_PRODUCT = 0.2
"""Of the largest product."""
PRODUCT, MATTERS = 0.01, 0.02
"""Largest product, and least difference that its sign makes, over the middle moment."""
_TRIANGLE = np.triu_indices(3, 1)


class Twin(NamedTuple):
    """A link's inertial, and what it would be if the other one were right."""

    name: str
    point: MassPoint
    tensors: list[Array]


def signs_unlike(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """Two links of the same mass (to 0.1 %), whose centres of mass are mirror images or quarter turns of each other (to
    0.2 %), and whose tensors have the same moments and products, but for the signs of the products: these go with no
    turn or mirror image of the centre. Of left and right, products that change sign are those of the axis that the
    centre changes sign along with one of the two others. The finding is at the link whose shapes fit worse, else at the
    later one. Differences below 2 % of the middle moment are not looked at.
    """
    said: set[str] = set()
    for first, second in combinations(_points(document), 2):
        pair = _unlike(first, second)
        if pair is None:
            continue
        wrong, right = _worse_first(pair, document)
        link = document.by_name[wrong.name]
        if wrong.name in said or link.inertial is None:
            continue
        said.add(wrong.name)
        one = len({np.round(t, 12).tobytes() for t in wrong.tensors}) == 1
        yield UrdfFinding(
            f"the signs of its products of inertia do not go with those of link {right.name}",
            "equal masses, centres and moments but for signs and order; one of the two tensors is wrong",
            link.inertial.tensor_place, link.subject, _text(document, wrong) if one else "", "likely",
            "signs of products unlike those of the mirrored link", link=wrong.name,
        )  # fmt: skip


def _text(document: UrdfDocument, wrong: Twin) -> str:
    inertial = document.by_name[wrong.name].inertial
    rotation = None if inertial is None else inertial.origin.rotation
    return "" if rotation is None else inertia_text(rotation.T @ wrong.tensors[0] @ rotation)


def _points(document: UrdfDocument) -> list[tuple[str, MassPoint]]:
    """The moved links whose tensors have products that matter."""
    found = []
    for link in document.by_name.values():
        point = as_written(link.inertial) if link.inertial is not None and link.name in document.moved else None
        if point is not None and np.abs(point.inertia[_TRIANGLE]).max() > PRODUCT * np.median(point.inertia.diagonal()):
            found.append((link.name, point))
    return found


def _unlike(first: tuple[str, MassPoint], second: tuple[str, MassPoint]) -> tuple[Twin, Twin] | None:
    """The two links, if one is the image of the other but for signs of products."""
    (a, one), (b, two) = first, second
    far, size = float(np.linalg.norm(one.com)), float(np.abs(one.inertia).max())
    if abs(one.mass - two.mass) > SAME_MASS * one.mass or not far > 0.0:
        return None
    turns = _turns()
    turns = turns[np.abs(turns @ one.com - two.com).max(axis=1) <= SAME_CENTRE * far]
    images = turns @ one.inertia @ turns.swapaxes(1, 2)
    of_moments, of_products = SAME_TENSOR * size, SAME_PRODUCT * float(np.abs(two.inertia[_TRIANGLE]).max())
    slack = np.where(np.eye(3) == 1.0, of_moments, min(of_products, of_moments))
    alike = (np.abs(np.abs(images) - np.abs(two.inertia)) <= slack).all(axis=(1, 2))
    if not alike.any() or (np.abs(images - two.inertia) <= slack).all(axis=(1, 2)).any():
        return None
    turns, images = turns[alike], images[alike]
    if np.abs(images - two.inertia).max(axis=(1, 2)).min() < MATTERS * np.median(two.inertia.diagonal()):
        return None
    back = turns.swapaxes(1, 2) @ two.inertia @ turns
    return Twin(a, one, list(back)), Twin(b, two, list(images))


@lru_cache(maxsize=1)
def _turns() -> Array:
    """The 48 turns by quarters and their mirror images, (48, 3, 3)."""
    out = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        out.append(np.eye(3)[list(order)] * np.array(signs)[:, None])
    return np.array(out)


def _worse_first(pair: tuple[Twin, Twin], document: UrdfDocument) -> tuple[Twin, Twin]:
    """The link whose tensor fits its shapes worse than the other's image does, else the later one, first."""
    hulls = {x.body.link.name: x.hull for x in judgements(document)}
    if not all(twin.name in hulls for twin in pair):
        return pair[1], pair[0]
    gains = []
    for twin in pair:
        tensors = np.array([twin.point.inertia, *twin.tensors])
        distances = log_distance(spread_ratios(tensors, twin.point.mass, hulls[twin.name]))
        gains.append(float(distances[0] - distances[1:].min()))
    return pair if gains[0] > gains[1] else (pair[1], pair[0])
