"""Links as a URDF file writes them, before fixed joints weld them together.

A fault of one link can vanish in the sum of the links that move with it, so each is judged by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.model.chain import Body


@dataclass(frozen=True, slots=True, eq=False)
class WrittenLink:
    """A link of the file; `body` is None where it has no `<inertial>`."""

    link: str
    body: Body | None
    """In the frame of the link that a joint moves; in the frame of the root where nothing moves it."""


def welded(links: Sequence[WrittenLink]) -> Body | None:
    """The links rigidly joined; None where no link has an inertial.

    Zeros on a frame say nothing about the first link, to which the others are welded.
    """
    joined: Body | None = None
    for _, body in heavy(links):
        joined = body if joined is None else joined + body
    return joined


def heavy(links: Sequence[WrittenLink]) -> list[tuple[str, Body]]:
    """The links whose inertials count, with their bodies."""
    given = [(link, link.body) for link in links if link.body is not None]
    return [(link.link, body) for link, body in given if link is links[0] or not is_weightless(body)]


def is_weightless(body: Body) -> bool:
    """Whether the inertial is one of zeros, as on a frame."""
    return body.mass == 0.0 and not body.inertia_com.any() and not body.unknown
