"""The documentation site: Sphinx with MyST and Furo; ``make docs`` builds it into build/docs.

Warnings are errors. Nothing on a page is fetched from another host, so that the site opens from a
folder on a laptop at sea.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # the directives of docs/from_code

from mission import __version__

project = "auvmission"
author = "the auvmission authors"
project_copyright = author
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "from_code"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["from_code", "pictures", "static"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4  # links such as rules.md#who-decides, as on GitHub

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
python_use_unqualified_type_names = True

html_theme = "furo"
html_title = f"auvmission {release}"
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_search_summary = False  # a page from a folder may not fetch others
html_static_path = ["static"]
html_css_files = ["site.css"]
