"""VTK's fixed-point ray caster, its only volume renderer for the CPU, and its OpenGL mapper as the reference.

Three things make both show the scene that was asked for (VTK 9.7.2, found by comparing pictures):
- the fixed-point mapper multiplies the ambient share by the light's ambient colour, which is black by default;
- its light and viewer are in one direction for the whole picture, and its highlight is Blinn's; the OpenGL mapper's
  are at the camera and Phong's: the reference's shader is given the former;
- the OpenGL mapper gets float samples: software OpenGL interpolates 8-bit textures in 8 bits.
"""

import os

import numpy as np
import vtkmodules.vtkRenderingOpenGL2
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  (registers the OpenGL back end)
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkMultiThreader, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import (
    vtkColorTransferFunction, vtkLight, vtkRenderer, vtkRenderWindow, vtkVolume, vtkVolumeProperty)
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper, vtkVolumeMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkOpenGLGPUVolumeRayCastMapper

import scenes
import timing

REFERENCE_STEP = 0.1
"""Sample distance of the reference, voxels."""

REFERENCE_LIGHT = {
    "float nDotL = dot(normal, -g_ldir[0]);": "float nDotL = dot(normal, towards_eye);",
    "float vDotR = dot(r, -g_vdir[0]);": "float vDotR = abs(nDotL);",
}
"""Replacements in VTK's fragment shader. check_reference.py fails where they do not take."""


BLEND = {
    "composite": vtkVolumeMapper.COMPOSITE_BLEND,
    "mip": vtkVolumeMapper.MAXIMUM_INTENSITY_BLEND,
}


class VtkError(Exception):
    """VTK cannot render here."""


class VtkRenderer:
    """An off-screen window of `size` pixels square; `mode`: one of `scenes.MODES`."""

    def __init__(self, size, threads, mode="composite"):
        vtkMultiThreader.SetGlobalMaximumNumberOfThreads(threads)
        vtkMultiThreader.SetGlobalDefaultNumberOfThreads(threads)
        os.environ.setdefault("LP_NUM_THREADS", str(threads))  # Mesa's software OpenGL reads this later.
        self.size, self.threads, self.mode = size, threads, mode
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(size, size)
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(0, 0, 0)
        self.renderer.AutomaticLightCreationOff()
        light = vtkLight()
        light.SetLightTypeToHeadlight()
        light.SetAmbientColor(1, 1, 1)
        self.renderer.AddLight(light)
        self.window.AddRenderer(self.renderer)
        self.pixels = vtkUnsignedCharArray()
        if not self.window.SupportsOpenGL():
            raise VtkError("VTK has no off-screen OpenGL, which even its CPU mapper needs to deliver pictures "
                           "(Debian: apt install libegl1 libgl1-mesa-dri)")

    def show(self, transfer_function, lighting, mapper):
        """Makes the volume the only thing in the scene, and returns it."""
        actor = vtkVolume()
        actor.SetMapper(mapper)
        actor.SetProperty(_property(transfer_function, lighting))
        self.renderer.RemoveAllViewProps()
        self.renderer.AddVolume(actor)
        return actor

    def frame(self, camera):
        """Renders; returns RGB, rows from the top."""
        seen = self.renderer.GetActiveCamera()
        seen.SetFocalPoint(*camera.target)
        seen.SetPosition(*camera.eye)
        seen.SetViewUp(*scenes.UP)
        seen.SetParallelProjection(camera.height is not None)
        seen.SetParallelScale((camera.height or 2.0) / 2)
        seen.SetViewAngle(scenes.FOV_DEGREES)
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        last = self.size - 1
        self.window.GetRGBACharPixelData(0, 0, last, last, 0, self.pixels)
        return vtk_to_numpy(self.pixels).reshape(self.size, self.size, 4)[::-1, :, :3]

    def fixed_point(self, volume, step=1.0):
        """The mapper that is measured; `step` in voxels."""
        mapper = vtkFixedPointVolumeRayCastMapper()
        mapper.SetNumberOfThreads(self.threads)
        mapper.SetInteractiveSampleDistance(step * volume.voxel)
        mapper.IntermixIntersectingGeometryOff()
        return self._configured(mapper, volume.values, volume, step)

    def on_gpu(self, volume, step=1.0):
        """The OpenGL mapper, which is measured against splatvol's GPU engine: the samples as they are, no jitter."""
        mapper = vtkOpenGLGPUVolumeRayCastMapper()
        mapper.UseJitteringOff()
        return self._configured(mapper, volume.values, volume, step)

    def device(self):
        """The OpenGL renderer's own name of its device."""
        self.window.Render()
        for line in self.window.ReportCapabilities().splitlines():
            if line.startswith("OpenGL renderer string:"):
                return line.partition(":")[2].strip()
        return "unknown"

    def batch(self, camera, orbit, frames, warm_up):
        """Times frames, each turned by `orbit` degrees against the one before."""
        return timing.measure(lambda i: self.frame(camera.turned(i * orbit)), frames, warm_up)

    def reference(self, volume, transfer_function, lighting, camera, step):
        """What the fixed-point mapper approximates: the OpenGL mapper on floats with short steps."""
        mapper = vtkOpenGLGPUVolumeRayCastMapper()
        mapper.UseJitteringOff()
        self._configured(mapper, volume.values.astype(np.float32), volume, step)
        actor = self.show(transfer_function, lighting, mapper)
        shader = actor.GetShaderProperty()
        for original, replacement in REFERENCE_LIGHT.items():
            shader.AddFragmentShaderReplacement(original, False, replacement, True)
        towards_eye = (camera.eye - camera.target) / np.linalg.norm(camera.eye - camera.target)
        shader.GetFragmentCustomUniforms().SetUniform3f("towards_eye", list(towards_eye))
        picture = self.frame(camera).copy()
        if not mapper.IsRenderSupported(self.window, actor.GetProperty()):
            raise VtkError("VTK's OpenGL mapper, the reference, does not work here")
        return picture

    def _configured(self, mapper, values, volume, step):
        mapper.SetImageSampleDistance(1.0)
        mapper.SetSampleDistance(step * volume.voxel)
        mapper.SetAutoAdjustSampleDistances(0)
        mapper.SetLockSampleDistanceToInputSpacing(0)
        mapper.SetBlendMode(BLEND[self.mode])
        image = vtkImageData()
        image.SetDimensions(*values.shape[::-1])
        image.SetSpacing(*volume.spacing)
        image.SetOrigin(*[volume.origin] * 3)
        image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=True))
        mapper.SetInputData(image)
        return mapper


def _property(transfer_function, lighting):
    opacity, color = vtkPiecewiseFunction(), vtkColorTransferFunction()
    for point in transfer_function.opacities:
        opacity.AddPoint(*point)
    for point in transfer_function.colors:
        color.AddRGBPoint(*point)
    made = vtkVolumeProperty()
    made.SetScalarOpacity(opacity)
    made.SetColor(color)
    made.SetInterpolationTypeToLinear()
    made.SetScalarOpacityUnitDistance(transfer_function.unit_distance)
    made.ShadeOn()
    made.SetAmbient(lighting.ambient)
    made.SetDiffuse(lighting.diffuse)
    made.SetSpecular(lighting.specular)
    made.SetSpecularPower(lighting.power)
    return made
