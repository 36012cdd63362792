"""splatvol, through its command."""

import io
import json
import subprocess

import numpy as np
from PIL import Image

import references
import scenes
import timing

TERMINATION = ["--termination", "0.0001"]
CONVERGED = ["--sheet-thickness", "0.125", *TERMINATION]
"""The same kernel, but thin sheets and (nearly) no early end."""
SETTINGS = "splatvol.settings"
"""The text of a PNG that says how it was made."""


class SplatvolError(Exception):
    """The command failed."""


class Splatvol:
    """The program, a folder for what it reads and writes, and flags that the user adds to every picture."""

    def __init__(self, program, folder, size, threads, extra=()):
        self.program, self.folder, self.size, self.threads, self.extra = program, folder, size, threads, list(extra)

    def run(self, *arguments):
        """Runs a command; returns its stdout as bytes."""
        command = [str(self.program), *map(str, arguments), "--quiet"]
        done = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            raise SplatvolError(f"{' '.join(command)}\n{done.stderr.decode(errors='replace').strip()}")
        return done.stdout

    def at_its_best(self):
        """The same program with its most exact method instead of the user's flags."""
        return Splatvol(self.program, self.folder, self.size, self.threads, ["--preset=best"])

    def digest(self):
        """What tells this program from others, of the same version too."""
        return references.of_file(self.program)

    def is_draft(self):
        """Whether pictures have less than full resolution."""
        flags = " ".join(self.extra).replace("=", " ")
        return "--preset draft" in flags or "--level-bias" in flags

    def version(self):
        """As `--version` says."""
        return self.run("--version").decode().strip()

    def read(self, reference):
        """A volume of any format that splatvol knows, or a `sample:NAME`."""
        path = reference.partition("@")[0]
        info = json.loads(self.run("info", "--json", path))
        samples = self.folder / "samples.npy"
        self.run("convert", path, samples, "--overwrite")
        return scenes.volume(reference, np.load(samples), info["spacing"])

    def scene(self, volume, transfer_function, lighting, camera):
        """Writes the scene's files; returns the arguments that show it."""
        nrrd, preset = self.folder / f"{volume.name}.nrrd", self.folder / "transfer-function.json"
        volume.write_nrrd(nrrd)
        transfer_function.write_paraview(preset)
        look = {
            # Without it, volumes that seem to stand on y are turned to z, in front of a camera that is not.
            "up": "z", "size": f"{self.size}x{self.size}", "tf": preset, "unit-distance": transfer_function.unit_distance,
            "threads": self.threads, "ambient": lighting.ambient, "diffuse": lighting.diffuse,
            "specular": lighting.specular, "specular-power": lighting.power, "camera-pos": _triple(camera.eye),
            "camera-target": _triple(camera.target), "camera-up": _triple(scenes.UP),
        }
        if camera.height:
            look["orthographic"] = camera.height
        else:
            look["camera-fov"] = scenes.FOV_DEGREES
        return [nrrd, *(f"--{name}={value}" for name, value in look.items()), *self.extra]

    def batch(self, scene, orbit, frames, warm_up):
        """Times frames, each turned by `orbit` degrees against the one before."""
        turning = ["--orbit", orbit, "--frames", frames, "--warm-up", warm_up, "--json", "-"]
        with timing.Machine() as machine:
            (case,) = json.loads(self.run("bench", *scene, *turning))["cases"]
        if case["cpu_ms"] is None:
            raise SplatvolError("splatvol bench knows no processor times on this system")
        return timing.Batch(case["wall_ms"], case["cpu_ms"], machine.others)

    def first_frame(self, scene):
        """RGB of the first frame that `batch` measures."""
        path = self.folder / "first-frame.png"
        self.run("bench", *scene, "--frames", 1, "--warm-up", 0, "--background", "black", "--picture", path, "--overwrite",
                 "--json", self.folder / "bench.json")
        with Image.open(path) as png:
            return np.array(png.convert("RGB"))

    def picture(self, scene, *more):
        """Renders the first frame; returns RGB and the settings it was made with. Later flags win over earlier."""
        flags = _without_overridden(list(map(str, scene)), list(map(str, more)))
        png = Image.open(io.BytesIO(self.run("render", *flags, "--background", "black", "-o", "-")))
        return np.array(png.convert("RGB")), json.loads(png.text[SETTINGS])


def _triple(position):
    return ",".join(repr(float(x)) for x in position)


def _without_overridden(flags, more):
    """The command takes each flag once: drops from `flags` what `more` gives again."""
    given = {flag.split("=")[0] for flag in more if flag.startswith("--")}
    kept = []
    skip = False
    for flag in flags:
        if skip:
            skip = False
        elif flag.split("=")[0] in given:
            skip = "=" not in flag
        else:
            kept.append(flag)
    return kept + more
