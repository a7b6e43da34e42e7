"""The words of a mission, each with its description, for completion and hover.

They come from the JSON Schema (schema.py); the variables of guards come from their registry.
"""

from __future__ import annotations

from collections.abc import Iterator

from mission.authoring.language.schema import Schema, schema
from mission.engine.variables import VARIABLES

Word = dict[str, str]


def vocabulary() -> list[Word]:
    """Rows ``{"word", "says", "of"}``. ``says``: the description. ``of``: mission, leg, group,
    handler, guard, or the table of the word (safety, assume, achieve)."""
    made = schema()
    parts = made["definitions"]
    handler = parts["handlers"]["items"]
    found = [
        *_words("mission", made),
        *_words("leg", parts["leg"]),
        *_words("group", parts["group"]),
        *_words("handler", handler),
    ]
    for table in ("safety", "assume", "achieve"):
        found += _words(table, made["properties"][table])
    return [*found, *_variables()]


def _words(of: str, table: Schema) -> Iterator[Word]:
    for word, said in table["properties"].items():
        yield {"word": word, "says": str(said.get("description", "")), "of": of}


def _variables() -> Iterator[Word]:
    for row in VARIABLES.values():
        unit = f" ({row.unit})" if row.unit else ""
        yield {"word": row.name, "says": f"{row.description}{unit}", "of": "guard"}
