"""Times gsplat on an NVIDIA GPU: gsplat_renderer.py GAUSSIANS.ply BENCH.json PICTURE.png.

The Gaussians are `gaussians.py`'s, with harmonics of degree 3; the camera and the picture's size are those of
`splatvol bench GAUSSIANS.ply --engine gpu --orbit 0 --background black --json BENCH.json`. Needs PyTorch and gsplat,
which compiles its kernels when it is first imported.
"""

import json
import sys
from pathlib import Path

import numpy as np
import torch
from gsplat import rasterization
from PIL import Image

# Numbers of a Gaussian: place, colour, 45 coefficients, opacity, scales, rotation.
NUMBERS = 59
# As the published renderer, and splatvol, leave Gaussians out.
NEAR = 0.2
WARM_UP, FRAMES = 5, 30


def gaussians(path: Path) -> dict[str, torch.Tensor]:
    """Gaussians of a file, as gsplat takes them."""
    with path.open("rb") as file:
        header = b""
        while not header.endswith(b"end_header\n"):
            header += file.readline()
        numbers = np.fromfile(file, np.float32).reshape(-1, NUMBERS)
    all_ = torch.from_numpy(numbers).cuda()
    rest = all_[:, 6:51].reshape(-1, 3, 15).transpose(1, 2)
    return {
        "means": all_[:, :3].contiguous(),
        "colors": torch.cat([all_[:, None, 3:6], rest], dim=1).contiguous(),
        "opacities": all_[:, 51].sigmoid(),
        "scales": all_[:, 52:55].exp(),
        "quats": torch.nn.functional.normalize(all_[:, 55:59], dim=1),
    }


def camera(case: dict, width: int, height: int) -> dict[str, torch.Tensor]:
    """A camera of `bench`, in the Gaussians' own space: x right, y down, z forward."""
    of = case["camera"]
    position, target, up = (
        np.array([x, -z, y]) for x, y, z in (of[key] for key in ("position", "target", "up"))
    )
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    view = np.eye(4)
    view[:3, :3] = rotation
    view[:3, 3] = -rotation @ position
    fov = np.radians(of["projection"]["perspective"]["fov_degrees"])
    focal = height / 2 / np.tan(fov / 2)
    intrinsics = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    tensor = lambda array: torch.tensor(array[None], dtype=torch.float32).cuda()
    return {"viewmats": tensor(view), "Ks": tensor(intrinsics)}


@torch.no_grad()
def main(path: Path, bench: Path, picture: Path) -> None:
    """Prints the median of all frames, and writes the picture."""
    width, height = 1920, 1080
    case = json.loads(bench.read_text())["cases"][0]
    request = gaussians(path) | camera(case, width, height)
    request |= {"width": width, "height": height, "sh_degree": 3, "packed": False, "near_plane": NEAR}
    times = []
    for _ in range(WARM_UP + FRAMES):
        start, end = (torch.cuda.Event(enable_timing=True) for _ in range(2))
        start.record()
        image, *_ = rasterization(**request)
        end.record()
        torch.cuda.synchronize()
        times.append(start.elapsed_time(end))
    print(f"gsplat: {np.median(times[WARM_UP:]):.2f} ms")
    levels = (image[0].clamp(0, 1).cpu().numpy() * 255 + 0.5).astype(np.uint8)
    Image.fromarray(levels).save(picture)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:4]))
