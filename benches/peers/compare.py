#!/usr/bin/env python3
"""Compares splatvol with VTK's fixed-point volume ray caster: time per frame and quality, in the same run.

Both render the same samples, transfer functions, cameras and lights. Batches of frames alternate, so that what else the
machine does meets both. Quality is PSNR and SSIM against the renderer's own converged picture of the scene; for
marschner-lobb against the same renderer's picture of the function itself. Needs Python 3.11 and, once, the network.
"""

import environment

if __name__ == "__main__":
    environment.enter()

import argparse
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import cold_start
import references
import report
import scenes
from cases import Comparison
from splatvol_renderer import Splatvol, SplatvolError
from vtk_renderer import VtkError

ROOT = Path(__file__).resolve().parents[2]
SCANS = ROOT.parent / "shared/data/volumes"
RESULTS = Path(__file__).resolve().parent / "results"
EXAMPLES = """examples:
  compare.py                                    the default volumes: a few minutes
  compare.py sample:shells --tf semi --rounds 5
  compare.py scan.nii.gz@300 --view diag --orthographic
  compare.py sample:marschner-lobb --pictures out
  compare.py bonsai.vti --mode mip --preset fast
  compare.py engine.vti --only vtk --json vtk.json
  compare.py --preset fast --record             a table of this machine in benches/peers/results
  compare.py --engine gpu --preset fast --size 1024
  compare.py --cold-start bonsai.vti            process start to picture written, with PyVista too"""


def arguments():
    """The parsed command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volumes", nargs="*", metavar="VOLUME[@ISO]",
                        help="files that splatvol reads, or sample:NAME[:SIZE]; ISO is the surface of the opaque "
                        "transfer function [default: sample:shells, the scans where present, sample:marschner-lobb]")
    parser.add_argument("--mode", choices=list(scenes.MODES), default="composite",
                        help="how values along a ray become a pixel [default: %(default)s]")
    parser.add_argument("--tf", choices=["opaque", "semi", "ramp"], action="append",
                        help="transfer function, repeatable [default: opaque and semi; ramp for mip]")
    parser.add_argument("--view", choices=list(scenes.VIEWS), default="side", help="first view [default: %(default)s; "
                        "front for marschner-lobb]")
    parser.add_argument("--orthographic", action="store_true", help="parallel projection instead of perspective")
    parser.add_argument("--size", type=positive, default=512, help="pixels of a side [default: %(default)s]")
    parser.add_argument("--threads", type=positive, default=2, help="[default: %(default)s]")
    parser.add_argument("--orbit", type=float, default=1.0, metavar="DEGREES", help="per frame [default: %(default)s]")
    parser.add_argument("--frames", type=positive, default=9, help="per batch [default: %(default)s]")
    parser.add_argument("--warm-up", type=int, default=2, help="frames before a batch [default: %(default)s]")
    parser.add_argument("--rounds", type=positive, default=3, help="batches of each renderer [default: %(default)s]")
    parser.add_argument("--engine", choices=["cpu", "gpu"], default="cpu", help="splatvol's engine; gpu is compared with "
                        "VTK's OpenGL mapper on the same device [default: %(default)s]")
    parser.add_argument("--vtk-step", type=float, default=1.0, metavar="VOXELS",
                        help="distance of VTK's samples [default: %(default)s]")
    parser.add_argument("--only", choices=["vtk", "splatvol"], help="run one renderer")
    parser.add_argument("--no-quality", action="store_true", help="skip pictures and references: times only")
    parser.add_argument("--no-times", action="store_true", help="skip the batches: quality only")
    parser.add_argument("--preset", help="splatvol's --preset")
    parser.add_argument("--flag", action="append", default=[], metavar="FLAG",
                        help="another flag for splatvol, repeatable: --flag=--kernel-sigma=0.6")
    parser.add_argument("--splatvol", type=Path, help="the program [default: target/release/splatvol, or on PATH]")
    parser.add_argument("--references", type=Path, metavar="DIR", default=references.DEFAULT_FOLDER,
                        help="keep converged pictures here between runs, by samples, look, camera and program "
                        "[default: %(default)s]")
    parser.add_argument("--fresh-references", action="store_true", help="make converged pictures anew, and keep none")
    parser.add_argument("--record", type=Path, metavar="DIR", nargs="?", const=RESULTS,
                        help="write the table, with date and processor, to a file of this machine in a folder "
                        "[default: benches/peers/results]")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="save both renderers' pictures and references")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure")
    parser.add_argument("--cold-start", action="store_true", help="time whole processes instead of frames")
    return parser.parse_args()


def positive(text):
    """An integer from 1 on."""
    number = int(text)
    if number < 1:
        raise ValueError
    return number


def find_splatvol(given):
    """The program: as given, as built here, or on the PATH."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    name = "splatvol.exe" if os.name == "nt" else "splatvol"
    for candidate in [given] if given else [target / "release" / name, shutil.which("splatvol")]:
        if candidate and Path(candidate).is_file():
            return Path(candidate).resolve()
    sys.exit(f"compare.py: no splatvol at {given or target / 'release' / name}: "
             "run cargo build --release -p splatvol-cli, or give --splatvol PROGRAM")


def default_volumes():
    """The built-in benchmark volumes, and the scans that lie beside the repository."""
    scans = [SCANS / name for name in ("bonsai.vti", "engine.vti", "LIDC2.vti", "tooth.nrrd")]
    if not SCANS.is_dir():
        print(f"skipped: {SCANS} absent, built-in volumes only", file=sys.stderr)
    return ["sample:shells", *(str(scan) for scan in scans if scan.is_file()), "sample:marschner-lobb"]


def default_scan():
    """What `--cold-start` reads unless told otherwise."""
    if not (SCANS / "bonsai.vti").is_file():
        sys.exit(f"compare.py: {SCANS / 'bonsai.vti'} is absent: give a file that VTK reads, too")
    return [str(SCANS / "bonsai.vti")]


def main():
    """Runs what the command line asks for."""
    args = arguments()
    program = find_splatvol(args.splatvol)
    for folder in filter(None, (args.pictures, args.json and args.json.resolve().parent)):
        folder.mkdir(parents=True, exist_ok=True)
    extra = [*(["--preset", args.preset] if args.preset else []), *args.flag]
    if args.engine == "gpu":
        extra.append("--engine=gpu")
    if args.mode != "composite":
        extra += ["--compositing", args.mode]
    with tempfile.TemporaryDirectory(prefix="splatvol-peers-") as name:
        splatvol = Splatvol(program, Path(name), args.size, args.threads, extra)
        document = report.machine(splatvol.version(), args.threads)
        if args.cold_start:
            document["cold-start"] = cold_start.measure(splatvol, args.volumes or default_scan(), args)
            print(report.cold_start_table(document))
        else:
            comparison = Comparison(args, splatvol)
            document["device"] = comparison.device()
            document["cases"] = []
            for reference in args.volumes or default_volumes():
                for case in comparison.cases(reference):
                    document["cases"].append(case)
                    print(report.progress(case), file=sys.stderr)
            print(report.table(document))
    if args.record:
        print(f"recorded in {report.record(document, args.record, extra)}", file=sys.stderr)
    if args.json:
        args.json.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    try:
        main()
    except (SplatvolError, VtkError, OSError) as error:
        sys.exit(f"compare.py: {error}")
    except KeyboardInterrupt:
        sys.exit("compare.py: interrupted")
