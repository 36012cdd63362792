"""One case: a volume under a transfer function, by both renderers."""

import dataclasses
import importlib.metadata
import statistics

from PIL import Image

import quality
import references
import scenes
from splatvol_renderer import CONVERGED, TERMINATION
from vtk_renderer import REFERENCE_STEP, VtkRenderer

LIGHTING = scenes.Lighting()
VTK_REFINEMENT = 8
"""How much finer the samples are that stand for Marschner and Lobb's function. Linear interpolation, which has 29 dB
on the coarse samples, gains 12 dB per halving, splatvol's kernel, with 36 dB, more than that."""
SPLATVOL_REFINEMENT = 4
ANALYTIC_STEP = 0.5
"""Of the finer samples, so shorter than `REFERENCE_STEP` of the coarse ones."""
INTERIOR_MARGIN = 3.0
"""Voxels at the sides of Marschner and Lobb's box that do not count: there the function is cut, not reconstructed."""


@dataclasses.dataclass
class Scene:
    """What both renderers are given."""

    volume: scenes.Volume
    transfer_function: scenes.TransferFunction
    camera: scenes.Camera

    def of(self, volume):
        """The same scene with other samples of the same world."""
        return dataclasses.replace(self, volume=volume)


class Comparison:
    """Runs cases with the settings of the command line."""

    def __init__(self, args, splatvol):
        self.args = args
        self.splatvol = None if args.only == "vtk" else splatvol
        self.vtk = None if args.only == "splatvol" else VtkRenderer(args.size, args.threads, args.mode)
        self.reader = splatvol
        self.references = references.References(None if args.fresh_references else args.references)

    def device(self):
        """What VTK draws on, where that is measured."""
        return self.vtk.device() if self.vtk and self.args.engine == "gpu" else None

    def cases(self, reference):
        """Yields the figures of each transfer function on a volume."""
        volume = self.reader.read(reference)
        analytic = reference.split("@")[0] == "sample:marschner-lobb"
        view = "front" if analytic else self.args.view
        camera = scenes.camera(volume, view, self.args.orthographic)
        for kind in self.args.tf or scenes.MODES[self.args.mode]:
            scene = Scene(volume, scenes.transfer_function(volume, kind), camera)
            case = {"volume": volume.name, "dims": volume.values.shape[::-1], "sample-type": str(volume.values.dtype),
                    "mode": self.args.mode, "transfer-function": kind, "view": view, "orthographic": self.args.orthographic}
            if not self.args.no_times:
                case.update(self._times(scene))
            if not self.args.no_quality:
                case.update(self._quality(case, scene, analytic))
            yield case

    def _times(self, scene):
        batches = {"vtk": [], "splatvol": []}
        steps = self.args.orbit, self.args.frames, self.args.warm_up
        if self.splatvol:
            arguments = self.splatvol.scene(scene.volume, scene.transfer_function, LIGHTING, scene.camera)
        if self.vtk:
            self._show_measured(scene)
        for _ in range(self.args.rounds):
            if self.vtk:
                batches["vtk"].append(self.vtk.batch(scene.camera, *steps))
            if self.splatvol:
                batches["splatvol"].append(self.splatvol.batch(arguments, *steps))
        times = {name: _summary(found) for name, found in batches.items() if found}
        if len(times) == 2:
            for key in ("wall_ms", "cpu_ms"):
                rounds = [statistics.median(getattr(v, key)) / statistics.median(getattr(s, key))
                          for v, s in zip(batches["vtk"], batches["splatvol"], strict=True)]
                times[f"ratio_{key[:-3]}"] = {"median": statistics.median(rounds), "rounds": rounds}
        return {"times": times}

    def _quality(self, case, scene, analytic):
        mask = scenes.interior(scene.volume, scene.camera, self.args.size, INTERIOR_MARGIN) if analytic else None
        found = {}
        for name, renderer in (("vtk", self.vtk), ("splatvol", self.splatvol)):
            if renderer:
                picture, reference = getattr(self, f"_{name}_pictures")(scene, analytic)
                self._save(case, f"{name}", picture)
                self._save(case, f"{name}-reference", reference)
                found[name] = quality.measure(picture, reference, mask)
        return {"quality": found}

    def _show_measured(self, scene):
        if self.args.engine == "gpu":
            mapper = self.vtk.on_gpu(scene.volume, self.args.vtk_step)
        else:
            mapper = self.vtk.fixed_point(scene.volume, self.args.vtk_step)
        self.vtk.show(scene.transfer_function, LIGHTING, mapper)

    def _vtk_pictures(self, scene, analytic):
        self._show_measured(scene)
        picture = self.vtk.frame(scene.camera).copy()
        truth = scene.of(scenes.marschner_lobb(VTK_REFINEMENT, whole_voxels=False)) if analytic else scene
        step = ANALYTIC_STEP if analytic else REFERENCE_STEP
        key = {"renderer": f"VTK {importlib.metadata.version('vtk')}", "step": step, "mode": self.args.mode,
               **references.of_scene(truth, LIGHTING, self.args.size)}
        return picture, self.references.picture(key, lambda: self.vtk.reference(
            truth.volume, scene.transfer_function, LIGHTING, scene.camera, step))

    def _splatvol_pictures(self, scene, analytic):
        arguments = self.splatvol.scene(scene.volume, scene.transfer_function, LIGHTING, scene.camera)
        picture = self.splatvol.picture(arguments)[0]
        key = {"renderer": self.splatvol.digest(), "flags": [] if analytic else self.splatvol.extra,
               "converged": "truth" if analytic else CONVERGED, **references.of_scene(scene, LIGHTING, self.args.size)}
        if analytic:
            return picture, self.references.picture(key, lambda: self._splatvol_truth(scene))
        return picture, self.references.picture(key, lambda: self.splatvol.picture(arguments, *self._converged())[0])

    def _converged(self):
        """The same kernel at full resolution, with thin sheets and nearly no early end."""
        return ["--engine=cpu", *CONVERGED, *(["--level-bias=0"] if self.splatvol.is_draft() else [])]

    def _splatvol_truth(self, scene):
        """The function itself, whatever preset and flags are compared with it."""
        exact = self.splatvol.at_its_best()
        look = scene.transfer_function, LIGHTING, scene.camera
        settings = exact.picture(exact.scene(scene.volume, *look))[1]
        # Opacities keep their world length. So must gradients, which splatvol counts per voxel.
        floor = settings["settings"]["gradient-floor"] / SPLATVOL_REFINEMENT
        fine = exact.scene(scenes.marschner_lobb(SPLATVOL_REFINEMENT, whole_voxels=True), *look)
        return exact.picture(fine, f"--gradient-floor={floor}", *TERMINATION)[0]

    def _save(self, case, name, picture):
        if self.args.pictures:
            stem = f"{case['volume']}-{case['transfer-function']}-{case['view']}"
            Image.fromarray(picture).save(self.args.pictures / f"{stem}-{name}.png")


def _summary(batches):
    """Medians over the frames of all batches, and all frames."""
    summary = {"others": max((b.others for b in batches if b.others is not None), default=None)}
    for key in ("wall_ms", "cpu_ms"):
        frames = [ms for batch in batches for ms in getattr(batch, key)]
        summary[key] = {"median": statistics.median(frames), "min": min(frames), "max": max(frames), "frames": frames}
    return summary
