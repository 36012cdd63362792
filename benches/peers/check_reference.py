#!/usr/bin/env python3
"""Checks VTK's reference picture against a ray caster that shares nothing with VTK.

In float64, straight from the definitions: trilinear samples, central differences at the samples, interpolated as
vectors, a directional light from the viewer. Exit code 1 where the two agree to less than 45 dB.
"""

import environment

if __name__ == "__main__":
    environment.enter()

import math
import sys

import numpy as np

import quality
import scenes
from vtk_renderer import REFERENCE_STEP, VtkRenderer

SIZE = 160
DEMANDED_DB = 45.0


class RayCaster:
    """A volume under a transfer function and light."""

    def __init__(self, volume, transfer_function, lighting):
        self.volume, self.lighting = volume, lighting
        self.opacities, self.colors = np.array(transfer_function.opacities), np.array(transfer_function.colors)
        self.unit_distance = transfer_function.unit_distance
        self.values = volume.values.astype(float)
        self.gradients = np.stack(np.gradient(self.values)[::-1], -1) / volume.spacing

    def render(self, camera, size):
        """RGB in 8 bits, rows from the top; perspective only."""
        back = (camera.eye - camera.target) / np.linalg.norm(camera.eye - camera.target)
        rays = _rays(back, size)
        ends = np.stack([-camera.eye / rays, (self.volume.extent - camera.eye) / rays])
        near, far = ends.min(0).max(1), ends.max(0).min(1)
        step = REFERENCE_STEP * self.volume.voxel
        picture, transmittance = np.zeros((len(rays), 3)), np.ones(len(rays))
        live = np.flatnonzero(far > near)
        distance = near + step / 2
        while len(live):
            alpha, color = self._shade(camera.eye + distance[live, None] * rays[live], back)
            alpha = 1 - (1 - alpha) ** (step / self.unit_distance)
            picture[live] += (transmittance[live] * alpha)[:, None] * color
            transmittance[live] *= 1 - alpha
            distance[live] += step
            live = live[(distance[live] < far[live]) & (transmittance[live] > 1e-4)]
        return np.rint(picture.clip(0, 1) * 255).astype(np.uint8).reshape(size, size, 3)

    def _shade(self, points, back):
        value, gradient = self._interpolate(points)
        length = np.linalg.norm(gradient, axis=1)
        facing = np.abs(gradient @ back) / np.where(length > 0, length, 1)
        light = self.lighting
        color = np.stack([np.interp(value, self.colors[:, 0], self.colors[:, i]) for i in (1, 2, 3)], 1)
        lit = color * (light.ambient + light.diffuse * facing)[:, None]
        highlight = light.specular * facing**light.power
        return np.interp(value, *self.opacities.T), np.minimum(lit + highlight[:, None], 1)

    def _interpolate(self, points):
        last = np.array(self.values.shape[::-1]) - 1
        voxel = (points / self.volume.spacing).clip(0, last)
        base = np.minimum(voxel.astype(int), last - 1)
        share = voxel - base
        value, gradient = 0.0, 0.0
        for corner in np.ndindex(2, 2, 2):
            weight = np.where(corner, share, 1 - share).prod(1)
            x, y, z = (base + corner).T
            value = value + weight * self.values[z, y, x]
            gradient = gradient + weight[:, None] * self.gradients[z, y, x]
        return value, gradient


def _rays(back, size):
    """Unit directions through the pixels' centres."""
    right = np.cross(scenes.UP, back)
    right /= np.linalg.norm(right)
    steps = ((np.arange(size) + 0.5) / size * 2 - 1) * math.tan(math.radians(scenes.FOV_DEGREES / 2))
    across, down = np.meshgrid(steps, steps)
    rays = across[..., None] * right - down[..., None] * np.cross(back, right) - back
    return (rays / np.linalg.norm(rays, axis=2, keepdims=True)).reshape(-1, 3)


def main():
    """Compares on a dented ball with long voxels; returns whether all pictures agree."""
    # Nothing at the sides, where the two take differences in different ways.
    arch = np.sin(np.pi * np.linspace(0, 1, 32))
    dents = 0.8 + 0.2 * np.cos(np.linspace(0, 20, 32))
    values = np.einsum("i,j,k->ijk", arch, arch * dents, arch * dents).astype(np.float32)
    volume = scenes.Volume("dented ball", values, np.array([1.0, 1.25, 2.0]), iso=0.4, window=(0.0, 1.0))
    camera, lighting = scenes.camera(volume, "side", False), scenes.Lighting()
    vtk = VtkRenderer(SIZE, threads=2)
    agree = True
    for kind in ("opaque", "semi"):
        transfer_function = scenes.transfer_function(volume, kind)
        ours = RayCaster(volume, transfer_function, lighting).render(camera, SIZE)
        theirs = vtk.reference(volume, transfer_function, lighting, camera, REFERENCE_STEP)
        found = quality.measure(theirs, ours)
        print(f"{kind}: {found['psnr_db']:.1f} dB, SSIM {found['ssim']:.4f}")
        agree &= found["psnr_db"] >= DEMANDED_DB
    return agree


if __name__ == "__main__":
    sys.exit(0 if main() else f"check_reference.py: below {DEMANDED_DB} dB")
