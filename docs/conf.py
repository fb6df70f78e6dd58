"""The site: `sphinx-build -W --keep-going docs docs/_build` (extra `docs`), without a network."""

import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_ext")]
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(HERE.parent), os.environ.get("PYTHONPATH")])
)  # of notebooks

from lwr_dyn.foundation.version import VERSION  # noqa: E402

project, author, copyright = "lwr_dyn", "The lwr_dyn authors", "The lwr_dyn authors, MIT"
version = release = VERSION
extensions = ["myst_nb", "sphinx.ext.autodoc", "numpydoc", "sphinx_copybutton", "sphinx_design"]
extensions += ["mathml", "look", "generated", "front_door", "gallery", "reports"]  # _ext/
exclude_patterns = ["_build", "_ext"]
source_suffix = {".md": "myst-nb"}

html_math_renderer = "mathml"
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "attrs_inline"]
myst_heading_anchors = 3
nb_execution_mode, nb_execution_raise_on_error, nb_execution_timeout, nb_merge_streams = "cache", True, 120, True
nb_execution_in_temp = True

numpydoc_show_class_members = False
autodoc_typehints, autodoc_member_order = "none", "bysource"
python_use_unqualified_type_names, toc_object_entries = True, False

html_theme, html_title = "furo", "lwr_dyn"
html_static_path, html_css_files, html_js_files = ["_static"], ["look.css", "site.css"], ["site.js"]
html_copy_source = html_show_sourcelink = html_show_sphinx = False
html_show_search_summary = False  # it fetches pages, which file:// forbids
copybutton_prompt_text, copybutton_prompt_is_regexp = r"\$ |>>> |\.\.\. ", True
copybutton_only_copy_prompt_lines = True
pygments_style, pygments_dark_style = "a11y-high-contrast-light", "a11y-high-contrast-dark"
