"""Converged pictures, kept between runs: each is named by a digest of all that it is made of."""

import hashlib
import json
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

DEFAULT_FOLDER = Path(tempfile.gettempdir()) / "splatvol-peers-references"


class References:
    """A folder of pictures; without one (None) every picture is made anew."""

    def __init__(self, folder):
        self.folder = folder
        self.found = 0
        """Pictures that were there already."""

    def picture(self, key, make):
        """The picture of this key, RGB in 8 bits: from the folder, or made and put there."""
        if self.folder is None:
            return make()
        path = self.folder / f"{digest(key)}.png"
        try:
            with Image.open(path) as kept:
                picture = np.array(kept.convert("RGB"))
            self.found += 1
            return picture
        except (FileNotFoundError, OSError):
            picture = make()
        self.folder.mkdir(parents=True, exist_ok=True)
        # Another run may write the same picture at this moment, and a run may be stopped while it writes.
        with tempfile.NamedTemporaryFile(dir=self.folder, suffix=".part", delete=False) as part:
            Image.fromarray(picture).save(part, format="png")
        Path(part.name).replace(path)
        return picture


def digest(key):
    """A name for a JSON-like key."""
    return hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:32]


def of_scene(scene, lighting, size):
    """The part of a key that says what is shown: samples, look, light, camera."""
    volume, camera = scene.volume, scene.camera
    return {
        "samples": hashlib.sha256(np.ascontiguousarray(volume.values)).hexdigest(),
        "dims": list(volume.values.shape), "type": volume.values.dtype.str,
        "spacing": volume.spacing.tolist(), "origin": float(volume.origin),
        "opacities": [[float(x) for x in point] for point in scene.transfer_function.opacities],
        "colors": [[float(x) for x in point] for point in scene.transfer_function.colors],
        "unit-distance": float(scene.transfer_function.unit_distance), "light": vars(lighting),
        "eye": camera.eye.tolist(), "target": camera.target.tolist(),
        "height": None if camera.height is None else float(camera.height), "size": size,
    }


def of_file(path):
    """Digest of a program: development builds share a version, and a reference must be of the program that is measured."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
