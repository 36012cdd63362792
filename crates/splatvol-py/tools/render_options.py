"""Writes `python/splatvol/_render_options.py` from the document's schema: keywords with their types, for editors.

Run it after the keys of documents have changed: `python tools/render_options.py`. A test compares the file.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from splatvol._options import READING
from splatvol._vocabulary import NO_KEYWORD, RENAMED, TABLES, schema

PATH = Path(__file__).parent.parent / "python" / "splatvol" / "_render_options.py"

HEAD = '''"""Keywords, their types and their meaning. Written by tools/render_options.py; do not edit."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, TypedDict

from ._camera import Camera
from ._look import Clip, Light, TransferFunction

'''

#: Types of keywords that take more than the document's keys do, and what they mean.
OWN = {
    "size": ("int | str | Sequence[int]", "Size of the picture, pixels: one number, or width and height."),
    "background": ("str | Sequence[float]", "Background: a name, #rrggbb, none, or sRGB and alpha from 0 to 1."),
    "camera": ("Camera", "Camera, in place of the keywords of cameras."),
    "clip": ("Clip | Sequence[Clip]", "What is cut away."),
    "light": ("bool | Light | Sequence[float]", "Whether surfaces are lit, a light, or the direction to one."),
    "norm": ("Any", "One of matplotlib's norms: how values become places in the colour map."),
    "vmin": ("float", "Value at the lower end of the colour map; the data's least by default."),
    "vmax": ("float", "Value at the upper end of the colour map; the data's greatest by default."),
    "cmap": ("str | Any", "Colour map: a name of splatvol's or matplotlib's, or one of matplotlib's maps."),
    "clim": (
        'tuple[float, float] | Sequence[float] | Literal["auto"]',
        "Data values at the ends of colour map and opacity curve.",
    ),
    "tf": ("TransferFunction | str | os.PathLike[str]", "Transfer function, or a file with one."),
    "opacity": (
        "str | float | Sequence[tuple[float, float]]",
        "Opacity curve of values, by its name or as points of value and opacity; opacity of points, 0..1.",
    ),
    "color": ("str | Sequence[float]", "Colour of points without colours."),
}


def type_of(shape: dict[str, Any]) -> str:
    """Python's type of a key."""
    if "$ref" in shape:
        return type_of(schema()["$defs"][shape["$ref"].rsplit("/", 1)[1]])
    if "enum" in shape:
        return "Literal[" + ", ".join(f'"{name}"' for name in shape["enum"] if name is not None) + "]"
    if "const" in shape:
        return f'Literal["{shape["const"]}"]'
    for several in ("anyOf", "oneOf"):
        if several in shape:
            names = [type_of(one) for one in shape[several] if one.get("type") != "null"]
            return one_literal(list(dict.fromkeys(names)))
    kinds = shape.get("type", "object")
    kinds = [kind for kind in ([kinds] if isinstance(kinds, str) else kinds) if kind != "null"]
    if kinds == ["array"]:
        entry = shape.get("items")
        return f"Sequence[{type_of(entry)}]" if isinstance(entry, dict) else "Sequence[Any]"
    names = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "object": "dict[str, Any]"}
    return " | ".join(names[kind] for kind in kinds)


def one_literal(names: list[str]) -> str:
    """Alternatives, those that are literals as one."""
    literals = [name[len("Literal[") : -1] for name in names if name.startswith("Literal[")]
    rest = [name for name in names if not name.startswith("Literal[")]
    return " | ".join([*rest, *([f"Literal[{', '.join(literals)}]"] if literals else [])])


def fields() -> dict[str, tuple[str, str]]:
    """Type and meaning of every keyword."""
    found = dict(OWN)
    for key in ("bits",):
        shape = schema()["properties"][key]
        found[key] = (type_of(shape), shape["description"])
    for table, definition in TABLES.items():
        for key, shape in schema()["$defs"][definition]["properties"].items():
            name = RENAMED.get((table, key), key.replace("-", "_"))
            if (table, key) not in NO_KEYWORD and name not in found:
                found[name] = (type_of(shape), shape["description"])
    return found


def generated() -> str:
    """The file."""
    all_fields = fields()
    reading = {name: all_fields[name] for name in READING}
    rest = {name: field for name, field in all_fields.items() if name not in READING}
    return HEAD + "\n\n".join(
        [
            typed("ReadOptions", "Keywords of :func:`splatvol.read`: how a file is read.", reading),
            typed("RenderOptions", "Keywords of pictures: the command's flags with ``_`` for ``-``.", rest),
        ]
    )


def typed(name: str, meaning: str, fields: dict[str, tuple[str, str]]) -> str:
    """A class of keywords."""
    lines = [f"class {name}(TypedDict, total=False):", f'    """{meaning}"""', ""]
    for field, (kind, about) in fields.items():
        lines += [f"    {field}: {kind} | None", f'    """{about}"""']
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    PATH.write_text(generated())
