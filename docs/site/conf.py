"""The site of the documentation: ./dev docs. Pages are Markdown; those of the models are made from what `samara models` says."""

import os

from pygments.lexers.special import TextLexer

project = "Samara"
author = "The Samara authors"
copyright = "2026, the Samara authors"
release = version = os.environ["SAMARA_VERSION"]

extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "index"
exclude_patterns = []
myst_heading_anchors = 4  # links to headings, as hosts of repositories make them
myst_enable_extensions = ["smartquotes"]
suppress_warnings = ["myst.header"]  # a page may begin below the first level

html_theme = "alabaster"
html_theme_options = {"description": "Parametric solutions of bodies in a fluid", "page_width": "1060px", "fixed_sidebar": True}
html_show_sourcelink = False
html_static_path = ["_static"]


def setup(app):
    app.add_lexer("csv", TextLexer)  # tables are shown as they are
