"""The site: the guides of docs/ by Sphinx, and beside them the headers' reference by Doxygen."""

project = "slipstream"
author = "The authors of slipstream"
extensions = ["myst_parser"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "slipstream"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
exclude_patterns = ["site"]


def keep_where_no_page(app, env, node, text):
    """Of links to folders of the repository the text is left."""
    target = node.get("reftarget", "")
    return text if target.startswith("../") else None


def setup(app):
    app.connect("missing-reference", keep_where_no_page)
