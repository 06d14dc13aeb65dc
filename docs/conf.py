"""Pages from the repository: `make docs` builds them, without a warning and without a look at the network."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # the checkout's packages, whatever is installed

from docutils import nodes
from docutils.parsers.rst import Directive

project = "delta-haptics"
author = "the authors of delta-haptics"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["gallery/figures.md", "reproduce.md"]  # included by other pages
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath"]
suppress_warnings = ["myst.xref_missing"]  # the packages' READMEs, included here, link to files beside themselves
html_theme = "furo"
html_title = "delta-haptics"
html_show_sphinx = False
html_copy_source = False
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}
html_show_copyright = False
napoleon_use_ivar = True
pygments_style = "friendly"


class Commands(Directive):
    """The help of every command of a package, as the command itself prints it at 86 columns."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Makes a section for each command."""
        import os
        from importlib import import_module

        os.environ["COLUMNS"] = "86"  # as many as a page is wide
        parser = import_module(f"{self.arguments[0]}.commands.cli").parser()
        made: list[nodes.Node] = []
        for name, command in _commands(parser).items():
            section = nodes.section(ids=[f"{self.arguments[0].replace('_', '-')}-{name}"])
            section += nodes.title(text=f"{self.arguments[0]} {name}")
            section += nodes.literal_block(text=command.format_help(), language="text")
            made.append(section)
        return made


def _commands(parser: Any) -> dict[str, Any]:
    return next(action.choices for action in parser._actions if isinstance(action.choices, dict))


def setup(app: Any) -> None:
    """Adds the directive `commands`."""
    app.add_directive("commands", Commands)
