"""Which worker of pytest-xdist runs which tests: a file is one worker's, so that what its tests share is made once.

Files whose tests share nothing are spread test by test; what takes longest begins first, so that no worker waits at
the end. `pytest -n auto` needs no option for it.
"""

import re
from collections.abc import Iterable
from typing import Any

LONGEST = (
    "tests/docs/test_site.py",
    "tests/docs/test_pages.py",
    "tests/reproduction/lwr4plus/test_study_main_job.py",
    "tests/custody/test_core_alone.py",
    "tests/reproduction/",
    "tests/checks/",
    "tests/design/",
    "tests/pages/",
    "tests/scripts/",
    "tests/studies/",
    "tests/identification/",
    "tests/codegen/",
    "tests/simulation/",
    "tests/trajectory/",
)
"""Files and folders that begin first, in this order."""
SPREAD = ("tests/docs/test_pages.py", "tests/custody/test_help_text.py", "tests/reproduction/test_compare_mutants.py")
"""Files with long tests that share nothing."""


def rank(name: str) -> int:
    """Place of a test among those that begin first; the number of them for all others."""
    return next((place for place, start in enumerate(LONGEST) if name.startswith(start)), len(LONGEST))


def scope(name: str) -> str:
    """What a worker takes as one piece: the file of a test, or the test."""
    file = re.split("::", name, maxsplit=1)[0]
    return name if file in SPREAD else file


def in_order(items: Iterable[Any]) -> list[Any]:
    """Collected tests, those first that take longest."""
    return sorted(items, key=lambda item: rank(item.nodeid))


def scheduler(config: Any, log: Any) -> Any:
    """The scheduler of pytest-xdist that goes by `scope`."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return scope(nodeid)

    config.option.loadscopereorder = False  # not by the number of tests
    return ByFile(config, log)
