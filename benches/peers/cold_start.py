"""From process start to picture written: splatvol, PyVista with nothing tuned, and VTK's fixed-point mapper.

Each program chooses its own camera, colours and opacities. The clock stops when the program says that the picture is
written, so that nobody's clean-up counts.
"""

import os
import statistics
import subprocess
import sys
import time

PYVISTA = """
import sys, pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(int(sys.argv[3]),) * 2)
plotter.add_volume(pyvista.read(sys.argv[1]))
plotter.screenshot(sys.argv[2])
print("written", flush=True)
"""

VTK_FIXED_POINT = """
import sys
from pathlib import Path
from PIL import Image
import scenes, vtk_renderer
from vtkmodules import vtkIOImage, vtkIOXML
from vtkmodules.util.numpy_support import vtk_to_numpy
reader = {".vti": lambda: vtkIOXML.vtkXMLImageDataReader(), ".nrrd": lambda: vtkIOImage.vtkNrrdReader(),
          ".mha": lambda: vtkIOImage.vtkMetaImageReader(), ".mhd": lambda: vtkIOImage.vtkMetaImageReader(),
          }[Path(sys.argv[1]).suffix]()
reader.SetFileName(sys.argv[1])
reader.Update()
image = reader.GetOutput()
values = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])
volume = scenes.volume(sys.argv[1], values, image.GetSpacing())
renderer = vtk_renderer.VtkRenderer(int(sys.argv[3]), int(sys.argv[4]))
renderer.show(scenes.transfer_function(volume, "semi"), scenes.Lighting(), renderer.fixed_point(volume))
Image.fromarray(renderer.frame(scenes.camera(volume, "side", False))).save(sys.argv[2])
print("written", flush=True)
"""


class ColdStartError(OSError):
    """A program failed."""


def measure(splatvol, volumes, args):
    """Times programs in turn, `args.rounds` times after one that fills the disk's cache."""
    size, threads = str(args.size), str(args.threads)
    found = []
    for volume in volumes:
        output = splatvol.folder / "cold-start.png"
        python = [sys.executable, "-c"]
        programs = {
            "splatvol render": [str(splatvol.program), "render", volume, "-w", "-o", str(output),
                                f"--size={size}x{size}", f"--threads={threads}", *splatvol.extra],
            "PyVista add_volume": [*python, PYVISTA, volume, str(output), size],
            "VTK fixed-point, semi, lit": [*python, VTK_FIXED_POINT, volume, str(output), size, threads],
        }
        runs = {name: [] for name in programs}
        for _ in range(1 + args.rounds):
            for name, command in programs.items():
                output.unlink(missing_ok=True)
                runs[name].append(_run(name, command, threads))
                if args.pictures:
                    (args.pictures / f"cold-start-{name.split()[0]}.png").write_bytes(output.read_bytes())
        for name, seconds in runs.items():
            wall, cpu = zip(*seconds[1:], strict=True)
            found.append({"program": name, "volume": volume.rsplit("/", 1)[-1], "wall_s": _spread(wall),
                          "cpu_s": _spread(cpu)})
    return found


def _run(name, command, threads):
    """Wall and CPU seconds; the CPU's until the process has ended."""
    here = os.path.dirname(os.path.abspath(__file__))
    surroundings = {**os.environ, "PYTHONPATH": here, "LP_NUM_THREADS": threads}
    before, start = os.times(), time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=surroundings) as run:
        said = next((line for line in run.stdout if line == "written\n"), "")  # Or its end.
        seconds = time.perf_counter() - start
        complaint = run.communicate()[1]
    if run.returncode != 0 or (command[1] == "-c" and not said):
        raise ColdStartError(f"{name} failed:\n{complaint.strip()}")
    after = os.times()
    return seconds, (after.children_user + after.children_system) - (before.children_user + before.children_system)


def _spread(values):
    return {"median": statistics.median(values), "min": min(values), "max": max(values), "all": list(values)}
