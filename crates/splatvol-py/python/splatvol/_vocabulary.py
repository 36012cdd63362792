"""Keywords: the command's flags with ``_`` for ``-``, and the keys of the document that they set.

The document's schema, which Rust writes, is the only list of keys. Keywords of items, camera, settings, effects and
motion are the keys' names; where a camera's key and an item's have one name, the camera's has the prefix ``camera_``.
"""

from __future__ import annotations

import difflib
import functools
import json
import re
from collections.abc import Mapping
from typing import Any

from . import _core, _translations
from ._errors import InvalidValue, UnknownKeyword

#: Tables of the document, and their definitions in the schema.
TABLES = {
    "item": "ItemKeys",
    "camera": "CameraKeys",
    "settings": "SettingKeys",
    "effects": "EffectKeys",
    "motion": "MotionKeys",
}
#: Keys of the document itself.
GENERAL = ("size", "background", "bits")
#: Keys that data decide, or other keywords.
NO_KEYWORD = {("item", "file"), ("item", "transfer-function"), ("motion", "camera"), ("motion", "sub-frames")}
#: Keywords with names of their own: the flags' where those differ from the keys.
RENAMED = {
    ("camera", "position"): "camera_position",
    ("camera", "target"): "camera_target",
    ("camera", "up"): "camera_up",
    ("item", "type"): "dtype",
}

Keys = dict[str, Any]


@functools.cache
def schema() -> Keys:
    """The JSON schema of documents."""
    loaded: Keys = json.loads(_core.schema())
    return loaded


@functools.cache
def keywords() -> Mapping[str, tuple[str, str]]:
    """Table and key of every keyword."""
    found = {key: ("", key) for key in GENERAL}
    for table, definition in TABLES.items():
        for key in schema()["$defs"][definition]["properties"]:
            if (table, key) not in NO_KEYWORD:
                found[RENAMED.get((table, key), key.replace("-", "_"))] = (table, key)
    return found


def check(names: Mapping[str, object], also: tuple[str, ...] = ()) -> None:
    """Refuses keywords that do not exist, by name.

    Raises
    ------
    UnknownKeyword
        With the keyword to write instead, where there is one.
    """
    known = keywords()
    for name in names:
        if name in known or name in also:
            continue
        hint = _translations.of(name)
        if hint is None:
            near = difflib.get_close_matches(name, [*known, *also], 1, 0.6)
            hint = f"did you mean {near[0]}=?" if near else "help(splatvol.RenderOptions) lists all"
        raise UnknownKeyword(f"{name}= is not a keyword of splatvol: {hint}", field=name)


def tables(options: Mapping[str, Any]) -> Keys:
    """A document of keywords and their values; its item is under ``"item"``. `None` leaves a key open."""
    document: Keys = {}
    for name, value in options.items():
        if value is None:
            continue
        table, key = keywords()[name]
        target = document.setdefault(table, {}) if table else document
        target[key] = checked(name, plain(value))
    return document


def checked(name: str, value: Any) -> Any:
    """The value of a keyword, if the document takes it.

    Raises
    ------
    InvalidValue
    """
    table, key = keywords()[name]
    try:
        text = json.dumps(value, allow_nan=False)
    except (TypeError, ValueError):
        raise InvalidValue(f"{name}: {value!r} is not allowed", field=name, value=repr(value)) from None
    why = _core.refusal(table, key, text)
    if why is not None:
        raise InvalidValue(f"{name}: {_in_words(why, value)}", field=name, value=repr(value))
    return value


#: What a value should be, by Rust's types.
_TYPES = {"f32": "a number", "f64": "a number", "a boolean": "True or False", "a sequence": "a list"}


def _in_words(why: str, value: Any) -> str:
    """A refusal without names of Rust's types."""
    found = re.fullmatch(r"[][\w.-]+: invalid type: .*, expected (.+)", why)
    if found is None:
        return why
    wanted = found[1]
    is_whole = re.fullmatch(r"[ui](8|16|32|64|size)", wanted)
    return f"{value!r} is not allowed, expected {'a whole number' if is_whole else _TYPES.get(wanted, wanted)}"


def is_allowed(name: str, text: str) -> bool:
    """Whether the document takes a text as the value of a keyword."""
    return _core.refusal(*keywords()[name], json.dumps(text)) is None


def plain(value: Any) -> Any:
    """A value as JSON has it: arrays become lists, numpy's numbers become Python's, paths become text."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "__fspath__"):
        return str(value.__fspath__())
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return value
