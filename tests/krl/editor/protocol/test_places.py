"""Places in texts of several lines, in the units of each encoding."""

import pytest
from lsprotocol.types import Position, Range

from lwr_dyn.krl.editor.protocol.places import Places

TEXT = "first\na\U0001f916b\n\nlast"


@pytest.mark.parametrize(("encoding", "after_robot"), [("utf-8", 5), ("utf-16", 3), ("utf-32", 2)])
def test_characters_of_a_text_are_found_in_their_lines(encoding, after_robot):
    places = Places(encoding)
    robot, last = TEXT.index("b"), TEXT.index("last")
    assert places.within(TEXT, 0, 5) == Range(Position(0, 0), Position(0, 5))
    assert places.within(TEXT, 6, robot) == Range(Position(1, 0), Position(1, after_robot))
    assert places.within(TEXT, last, len(TEXT)) == Range(Position(3, 0), Position(3, 4))
