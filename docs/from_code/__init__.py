"""Directives that write parts of a page from the code while the site is built.

    ```{from-code} WHAT [NAME]
    ```

WHAT is a row of PARTS; its maker returns Markdown. An unknown WHAT or NAME is an error of the page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from docutils import nodes
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import ExtensionMetadata

from from_code.cockpit import cockpit_pictures
from from_code.commands import command_part
from from_code.layers import layers_picture, rooms_table
from from_code.rows import rows_table
from from_code.tables import (
    alarms,
    diagnostic_codes,
    limits,
    link_schemes,
    simulation_settings,
    topic_tables,
    vehicle_pairs,
    vehicle_ranges,
)
from from_code.way import order_picture

PARTS: Mapping[str, Callable[[str], str]] = MappingProxyType(
    {
        "command": command_part,
        "cockpit": cockpit_pictures,
        "layers": lambda _: layers_picture(),
        "rooms": lambda _: rooms_table(),
        "order": order_picture,
        "diagnostic-codes": lambda _: diagnostic_codes(),
        "alarms": lambda _: alarms(),
        "limits": lambda _: limits(),
        "rows": rows_table,
        "link-schemes": lambda _: link_schemes(),
        "topics": lambda _: topic_tables(),
        "simulation-settings": lambda _: simulation_settings(),
        "vehicle-ranges": lambda _: vehicle_ranges(),
        "vehicle-pairs": lambda _: vehicle_pairs(),
    }
)


class FromCode(SphinxDirective):
    """Parses the Markdown of one part where the directive stands."""

    required_arguments = 1
    optional_arguments = 1

    def run(self) -> list[nodes.Node]:
        what, name = self.arguments[0], (self.arguments[1:] or [""])[0]
        if what not in PARTS:
            raise self.error(f"no part {what}; there are {', '.join(PARTS)}")
        try:
            text = PARTS[what](name)
        except LookupError as error:
            raise self.error(f"{what} {name}: {error}") from error
        if text.startswith("<svg"):
            return [nodes.raw("", f'<div class="drawn">{text}</div>', format="html")]
        return self.parse_text_to_nodes(text)


def setup(app: Sphinx) -> ExtensionMetadata:
    app.add_directive("from-code", FromCode)
    for language in ("mission", "guard"):  # of this project: shown as they stand
        app.add_lexer(language, TextLexer)
    return {"parallel_read_safe": True, "env_version": 1}
