"""What a diagnosis would write instead: the name that it asks for in `did you mean NAME?`."""

import re

from lwr_dyn.krl.diagnostics import Diagnostic

_MEANT = re.compile(r"did you mean (#?[\w$]+)\?")
_WORD = re.compile(r"#?[ \t]*[\w$]+")


def quick_fix(text: str, diagnostic: Diagnostic) -> tuple[int, int, str] | None:
    """First and last column (from 0) of the word that is replaced in its line, and the new word.

    None where the diagnosis means no other word, or no word stands at its place.
    """
    meant, word = _MEANT.search(diagnostic.hint), _WORD.match(text, diagnostic.position.column - 1)
    if meant is None or word is None:
        return None
    new, first = meant[1], word.start()
    if word[0].startswith("#") and not new.startswith("#"):
        first = word.end() - len(word[0].lstrip("# \t"))
    return first, word.end(), new
