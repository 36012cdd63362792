"""Sphinx's configuration. Guide and gallery have pictures that their programs make when the pages are built."""

from __future__ import annotations

import ast
import contextlib
import os
import runpy
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.image import imsave

import splatvol as sv
from splatvol import _translations

HERE = Path(__file__).parent
MADE = HERE / "made"

project = "splatvol"
author = "the splatvol developers"
release = sv.__version__
myst_enable_extensions = ["colon_fence"]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon"]
html_theme = "furo"
html_static_path = ["style.css"]
html_css_files = ["style.css"]
exclude_patterns = ["made/*.md"]
autosummary_generate = True
autodoc_typehints = "none"
autodoc_default_options = {"members": True, "undoc-members": False}
napoleon_numpy_docstring = True
napoleon_use_rtype = False


def make_pictures(part: str) -> None:
    """The picture of each program of a part: of a frame, or of an array of codes."""
    (MADE / part).mkdir(parents=True, exist_ok=True)
    for program in sorted((HERE / part).glob("*.py")):
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            frame = runpy.run_path(os.fspath(program), run_name=part)["frame"]
        imsave(MADE / part / f"{program.stem}.png", np.asarray(frame))


def make_gallery() -> None:
    """The gallery's pairs of a picture and its program, under the first line of the program."""
    pairs = [_pair(program) for program in sorted((HERE / "gallery").glob("*.py"))]
    (MADE / "gallery.md").write_text("\n".join(pairs))


def _pair(program: Path) -> str:
    title = ast.get_docstring(ast.parse(program.read_text())) or program.stem
    kind, _, _ = title.partition(":")
    return f"""{title}

:::{{container}} pair
![{kind}](made/gallery/{program.stem}.png)

```{{literalinclude}} gallery/{program.name}
:language: python
:lines: 3-
```
:::
"""


def make_tables() -> None:
    """Tables of keywords, from their types, and of other programs' keywords."""
    fields = {**sv.ReadOptions.__annotations__, **sv.RenderOptions.__annotations__}
    rows = ["| keyword | type |", "|---|---|"]
    rows += [f"| `{name}` | `{kind.replace('|', 'or')}` |" for name, kind in map(_spelt, fields.items())]
    (MADE / "keywords.md").write_text("\n".join(rows) + "\n")
    rows = ["| you wrote | here |", "|---|---|"]
    rows += [f"| `{name}=` | {hint} |" for name, hint in sorted(_translations.TABLE.items())]
    (MADE / "translations.md").write_text("\n".join(rows) + "\n")


def _spelt(field: tuple[str, object]) -> tuple[str, str]:
    name, kind = field
    text = getattr(kind, "__forward_arg__", None) or str(kind)
    return name, text.removesuffix(" | None")


make_pictures("guide")
make_pictures("gallery")
make_gallery()
make_tables()
