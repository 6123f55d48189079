"""Sphinx's configuration of the site (`make docs`). Warnings are errors; the pages load nothing from elsewhere."""

import os
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
BUILD = Path(os.environ.get("CMRC_BUILD_DIR", DOCS.parent / "build"))
SITE = Path(os.environ.get("CMRC_SITE_DIR", DOCS.parent / "build-docs"))
sys.path[:0] = [str(DOCS / "_site"), str(BUILD / "python")]

project = "CMRC emulator"
author = "the CMRC emulator's authors"
copyright = "the CMRC emulator's authors; Apache-2.0"
root_doc = "index"
extensions = ["myst_parser", "sphinx.ext.autodoc", "breathe", "pages"]
exclude_patterns = ["_site"]

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
suppress_warnings: list[str] = []

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
breathe_projects = {"cmrc": str(SITE / "doxygen" / "xml")}
breathe_default_project = "cmrc"
cpp_id_attributes: list[str] = []
highlight_language = "none"

html_theme = "furo"
html_title = "CMRC emulator"
html_copy_source = False
html_show_sphinx = False
