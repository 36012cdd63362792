"""Table 1 of mueller1998 by another way than the lab's: rows 2 to 5 in closed form, row 1 by Gauss-Legendre quadrature.

The kernel is exp(-1.38 r^2), cut at 2 voxels; 512^3 voxels, of which a fifth lies before z_k, seen at 512^2 pixels within 30
degrees of the axis. Prints the errors of footprints in levels of eight bits, and z_s - z_k, and demands that docs/lab.md has the
same: errors to four digits, z_s to half a voxel. Run: python tests-python/paper_footprints.py
"""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import numpy as np

STEEPNESS, CUT = 1.38, 2.0
Z_K = 256.0 / math.tan(math.radians(30.0))
EDGE = 256.0
FAR = 0.8 * 512.0
NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
ERF = np.vectorize(math.erf)


def gaussian(quadratic, low, high):
    """Integral of exp(-STEEPNESS q(z)) from low to high, q = a z^2 + b z + c with a > 0."""
    a, b, c = quadratic
    middle, least = -b / (2.0 * a), c - b * b / (4.0 * a)
    root = np.sqrt(STEEPNESS * a)
    part = ERF(root * (high - middle)) - ERF(root * (low - middle))
    return np.exp(-STEEPNESS * least) * part * math.sqrt(math.pi) / (2.0 * root)


def cut_gaussian(quadratic):
    """The same where q is less than CUT^2."""
    a, b, c = quadratic
    half = np.sqrt(np.maximum(b * b - 4.0 * a * (c - CUT * CUT), 0.0)) / (2.0 * a)
    middle = -b / (2.0 * a)
    return np.where(half > 0.0, gaussian(quadratic, middle - half, middle + half), 0.0)


def squared_sum(*lines):
    """Coefficients of the sum of (m z + n)^2."""
    return tuple(
        sum(term)
        for term in zip(*((m * m, 2.0 * m * n, n * n) for m, n in lines), strict=True)
    )


def trapezoid(y_v, z_v, y_p):
    """Row 1: stretched at each depth by what that depth needs."""
    slope = y_p / Z_K

    def squared(z):
        stretch = np.minimum(1.0, Z_K / z)
        return (stretch * (slope * z - y_v)) ** 2 + (z - z_v) ** 2

    depths = z_v + np.linspace(-CUT, CUT, 2001)[:, None]
    inside = squared(depths) < CUT * CUT
    first, last = inside.argmax(axis=0), len(depths) - 1 - inside[::-1].argmax(axis=0)
    step = 2.0 * CUT / 2000.0
    low, high = depths[first, 0], depths[last, 0]
    ends = []
    for within, beyond in ((low, low - step), (high, high + step)):
        for _ in range(50):
            between = 0.5 * (within + beyond)
            holds = squared(between) < CUT * CUT
            within, beyond = (
                np.where(holds, between, within),
                np.where(holds, beyond, between),
            )
        ends.append(within)
    total = np.zeros_like(y_p)
    bend = np.clip(Z_K, ends[0], ends[1])
    for start, end in ((ends[0], bend), (bend, ends[1])):
        z = 0.5 * (start + end) + 0.5 * (end - start) * NODES[:, None]
        values = np.minimum(1.0, Z_K / z) * np.exp(-STEEPNESS * squared(z))
        total += 0.5 * (end - start) * (WEIGHTS[:, None] * values).sum(axis=0)
    return np.where(inside.any(axis=0), total, 0.0) * np.hypot(slope, 1.0)


def rows(y_v, z_v, y_p):
    """Integrals of rows 2 to 5 for rays that meet the plane z = z_k at y_p."""
    slope, stretch, far = y_p / Z_K, min(1.0, Z_K / z_v), math.hypot(y_v, z_v)
    arc, one = np.hypot(slope, 1.0), np.ones_like(y_p)
    box = squared_sum((stretch * slope, -stretch * y_v * one), (one, -z_v * one))
    # dy z_v - dz y_v and dz z_v + dy y_v, with dy = slope z - y_v and dz = z - z_v.
    across = (stretch * (slope * z_v - y_v) / far, 0.0 * one)
    along = ((z_v + slope * y_v) / far, -(z_v * z_v + y_v * y_v) / far * one)
    ideal = squared_sum(across, along)

    def parallel(offset):
        half = np.sqrt(np.maximum(CUT * CUT - offset**2, 0.0))
        return np.exp(-STEEPNESS * offset**2) * gaussian(
            (one, 0.0 * one, 0.0 * one), -half, half
        )

    disc = stretch * far * (z_v * y_p - y_v * Z_K) / (z_v * Z_K + y_p * y_v)
    grid = stretch * (slope * z_v - y_v)
    return [
        stretch * arc * cut_gaussian(box),
        stretch * arc * cut_gaussian(ideal),
        stretch * parallel(disc),
        stretch * parallel(grid),
    ]


def errors(y_v, z_v, rays=801):
    """Largest errors of rows 2 to 5, in levels of the right footprint's peak.

    As many rays as the lab takes: cut kernels end with a step of .4 % of their height, which shows where a ray passes between
    the ends of two rows.
    """
    slope = y_v / z_v
    reach = 1.1 * CUT * (1.0 + slope * slope) * max(Z_K / z_v, 1.0)
    y_p = slope * Z_K + reach * np.linspace(-1.0, 1.0, rays)
    right = trapezoid(y_v, z_v, y_p)
    return [
        256.0 * np.abs(row - right).max() / right.max() for row in rows(y_v, z_v, y_p)
    ]


def switch():
    """z_s - z_k: from where on row 5 errs by at most .05 levels more than row 4 at the volume's edge."""
    low, high = 200.0, FAR
    for _ in range(30):
        middle = 0.5 * (low + high)
        _, _, ray, grid = errors(EDGE, Z_K + middle, 161)
        low, high = (low, middle) if grid - ray <= 0.05 else (middle, high)
    return high


def four_digits(value):
    return float(f"{value:.4g}")


def main():
    lab = (Path(__file__).parents[1] / "docs/lab.md").read_text()
    wrong = []
    for name, depth in (
        ("at the volume's edge at z_k", 0.0),
        ("at the edge of the far face", FAR),
    ):
        found = [four_digits(value) for value in errors(EDGE, Z_K + depth)]
        line = re.search(
            rf"^\| {re.escape(name)} \| 256 \|[^|]*\|(.*)\|$", lab, re.MULTILINE
        )
        listed = [float(cell) for cell in line.group(1).split("|")]
        print(f"{name}: {found} levels, docs/lab.md has {listed}")
        if any(abs(a - b) > 1e-3 * b for a, b in zip(found, listed, strict=True)):
            wrong.append(name)
    found = switch()
    listed = float(
        re.search(r"\| z_s - z_k, [^|]*\| 70 \| ([\d.]+) voxels", lab).group(1)
    )
    print(f"z_s - z_k: {found:.2f} voxels, docs/lab.md has {listed}")
    # The lab halves its interval until it is half a voxel long.
    if abs(found - listed) > 0.5:
        wrong.append("z_s")
    if wrong:
        sys.exit(f"docs/lab.md differs: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
