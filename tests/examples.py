"""How many examples a property sees: its own count in the tests, the full count in `scripts/soak.py`."""

import os

from hypothesis import settings

SOAK = 2000


def examples(count: int) -> settings:
    """A decorator: `count` examples, or `SOAK` under the profile "soak"."""
    return settings(max_examples=SOAK if os.environ.get("LWR_DYN_HYPOTHESIS") == "soak" else count, deadline=None)
