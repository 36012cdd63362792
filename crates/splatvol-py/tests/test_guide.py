"""The programs of the guide and of the gallery run, and make the pictures that the pages show."""

from __future__ import annotations

import hashlib
import json
import os
import runpy
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parent.parent / "docs"
PROGRAMS = sorted(
    path.relative_to(DOCS).as_posix() for part in ("guide", "gallery") for path in (DOCS / part).glob("*.py")
)


@pytest.mark.parametrize("program", PROGRAMS)
def test_programs_make_their_pictures(program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After an intended change look at the pictures, and run with ``RENEW_HASHES=1``."""
    part, name = program.split("/")
    hashes = DOCS / part / "hashes.json"
    monkeypatch.chdir(tmp_path)
    frame = runpy.run_path(str(DOCS / program), run_name=part)["frame"]
    found = hashlib.sha256(np.asarray(frame).tobytes()).hexdigest()
    known = json.loads(hashes.read_text()) if hashes.exists() else {}
    if os.environ.get("RENEW_HASHES"):
        hashes.write_text(json.dumps({**known, name: found}, indent=2, sort_keys=True) + "\n")
    else:
        assert found == known.get(name), "look at the picture, then RENEW_HASHES=1"
