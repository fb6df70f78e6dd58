"""Pages of arms, each written once, and the page that a module looks at (`SHOWN`, a name of `explored_arm`)."""

from functools import cache

import pytest

from lwr_dyn.pages.explorer.page import write_explorer
from tests.pages.explorer.explored import explored_arm, opened


@pytest.fixture(scope="session")
def page_of(tmp_path_factory):
    """The page of an arm, or of the arm of a name."""
    folder = tmp_path_factory.mktemp("explored")

    @cache
    def page(arm):
        path = folder / f"{page.cache_info().misses}.html"
        write_explorer(path, explored_arm(arm) if isinstance(arm, str) else arm)
        return path

    return page


@pytest.fixture(scope="module")
def page(request, page_of):
    return page_of(request.module.SHOWN)


@pytest.fixture(scope="module")
def window(browser, page):
    return opened(browser, page.as_uri())
