"""Data sets of pydicom and files of tifffile: the command's arrangement of slices, channels and lengths."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import splatvol as sv

from .conftest import shared

Command = Callable[..., np.ndarray]


@pytest.mark.parametrize("folder", ["dicom_ct_phantom", "dicom_mr_oblique"])
def test_lists_of_datasets_are_rendered_as_the_folder_is(folder: str, command: Command) -> None:
    pydicom = pytest.importorskip("pydicom")
    path = shared("volumes", folder)
    datasets = [pydicom.dcmread(file, force=True) for file in path.rglob("*") if file.is_file()]
    frame = sv.render(datasets, size=128)
    np.testing.assert_array_equal(np.asarray(sv.from_dicom(datasets)), np.asarray(sv.read(path)))
    assert sv.compare(frame, command(path, "--size", "128")).psnr > 50


def dataset(pixels: np.ndarray, **keys: Any) -> Any:
    pydicom = pytest.importorskip("pydicom")
    made = pydicom.Dataset()
    made.file_meta = pydicom.dataset.FileMetaDataset()
    made.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
    made.file_meta.MediaStorageSOPClassUID = made.SOPClassUID = pydicom.uid.MRImageStorage
    made.file_meta.MediaStorageSOPInstanceUID = made.SOPInstanceUID = pydicom.uid.generate_uid()
    made.SeriesInstanceUID, made.Modality, made.SeriesDescription = "1.2.3", "MR", "ball"
    made.Rows, made.Columns = pixels.shape[-2:]
    made.SamplesPerPixel, made.PhotometricInterpretation = 1, "MONOCHROME2"
    made.BitsAllocated, made.BitsStored, made.HighBit, made.PixelRepresentation = 16, 12, 11, 0
    made.PixelData = pixels.astype("<u2").tobytes()
    if pixels.ndim == 3:
        made.NumberOfFrames = len(pixels)
    for name, value in keys.items():
        setattr(made, name, value)
    return made


def group(**sequences: dict[str, Any]) -> Any:
    pydicom = pytest.importorskip("pydicom")
    made = pydicom.Dataset()
    for name, keys in sequences.items():
        inside = pydicom.Dataset()
        for key, value in keys.items():
            setattr(inside, key, value)
        setattr(made, name, [inside])
    return made


def test_frames_of_one_dataset_lie_as_the_command_puts_them(ball: np.ndarray, tmp_path: Path, command: Command) -> None:
    codes = (ball * 3000).astype(np.uint16)
    shared_group = group(
        PlaneOrientationSequence={"ImageOrientationPatient": [0, 1, 0, 0, 0, -1]},
        PixelMeasuresSequence={"PixelSpacing": [2, 1], "SliceThickness": 3},
        PixelValueTransformationSequence={"RescaleSlope": 2, "RescaleIntercept": -1000},
    )
    # From the last to the first.
    places = [group(PlanePositionSequence={"ImagePositionPatient": [-50 + 3 * z, 4, 5]}) for z in range(len(codes))][
        ::-1
    ]
    made = dataset(codes, SharedFunctionalGroupsSequence=[shared_group], PerFrameFunctionalGroupsSequence=places)
    path = tmp_path / "frames.dcm"
    made.save_as(path, enforce_file_format=True)
    theirs = sv.read(path)
    ours = sv.Volume.from_dicom(made)
    assert isinstance(theirs, sv.Volume)
    np.testing.assert_allclose(ours.affine, theirs.affine)
    np.testing.assert_array_equal(np.asarray(ours), np.asarray(theirs))
    assert ours.range == theirs.range and ours.unit == "mm" and ours.name == "ball"
    assert sv.compare(sv.render(made, size=96), command(path, "--size", "96")).psnr > 50


def test_one_frame_without_a_place_and_inverted_samples(ball: np.ndarray, tmp_path: Path) -> None:
    codes = (ball[10] * 3000).astype(np.uint16)
    made = dataset(codes, PhotometricInterpretation="MONOCHROME1", PixelSpacing=[1, 2])
    path = tmp_path / "one.dcm"
    made.save_as(path, enforce_file_format=True)
    with pytest.warns(sv.DataWarning):
        theirs = sv.read(path)
    np.testing.assert_array_equal(np.asarray(sv.from_dicom(made)), np.asarray(theirs))
    assert sv.from_dicom(made).spacing == theirs.spacing  # type: ignore[attr-defined]


def test_datasets_that_are_no_volume_say_why(ball: np.ndarray) -> None:
    codes = (ball * 3000).astype(np.uint16)
    axial = {"ImageOrientationPatient": [1, 0, 0, 0, 1, 0], "PixelSpacing": [1, 1]}
    slices = [dataset(part, ImagePositionPatient=[0, 0, 2 * z], **axial) for z, part in enumerate(codes)]
    np.testing.assert_array_equal(np.asarray(sv.from_dicom(slices[::-1])), codes)
    with pytest.raises(sv.InvalidValue, match="missing"):
        sv.from_dicom([*slices[:5], *slices[9:]])
    twice = [*slices, *[dataset(part + 1, ImagePositionPatient=[0, 0, 2 * z], **axial) for z, part in enumerate(codes)]]
    np.testing.assert_array_equal(
        np.asarray(sv.render(twice, time=1, size=32)), np.asarray(sv.render(twice[20:], size=32))
    )
    with pytest.raises(sv.InvalidValue, match="time: 2"):
        sv.from_dicom(twice, time=2)
    with pytest.warns(sv.DataWarning, match="left out"):
        sv.from_dicom(twice[:21])
    with pytest.raises(sv.InvalidValue, match="pixels"):
        sv.from_dicom([slices[0], dataset(codes[0, :10])])
    with pytest.raises(sv.InvalidValue, match="directions"):
        sv.from_dicom([slices[0], dataset(codes[0], ImageOrientationPatient=[0, 1, 0, 0, 0, 1])])


@pytest.mark.parametrize("unit", ["micron", "cm", "pixel", "\\u00B5m"])
def test_imagejs_lengths_are_the_commands(unit: str, ball: np.ndarray, tmp_path: Path, command: Command) -> None:
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "stack.tif"
    samples = np.stack([ball, ball[::-1] ** 2], axis=1)
    metadata = {"axes": "ZCYX", "spacing": 3.0, "unit": unit}
    tifffile.imwrite(path, samples, imagej=True, resolution=(4.0, 2.0), metadata=metadata)
    with tifffile.TiffFile(path) as file:
        with pytest.warns(sv.DataWarning, match="channel 0 of 2"):
            ours = sv.read(file)
        frame = sv.render(file.series[0], channel=1, size=64)
    theirs = sv.read(path, channel=0)
    assert isinstance(ours, sv.Volume) and isinstance(theirs, sv.Volume)
    assert (ours.spacing, ours.unit, ours.shape) == (theirs.spacing, theirs.unit, theirs.shape)
    np.testing.assert_array_equal(np.asarray(ours), np.asarray(theirs))
    assert sv.compare(frame, command(path, "--channel", 1, "--size", 64)).psnr > 50


def test_omes_lengths_are_the_commands(ball: np.ndarray, tmp_path: Path) -> None:
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "stack.ome.tif"
    metadata = {"axes": "TZYX", "PhysicalSizeX": 0.5, "PhysicalSizeY": 0.25, "PhysicalSizeZ": 2.0}
    tifffile.imwrite(path, np.stack([ball, ball * 0.5]), metadata=metadata)
    with tifffile.TiffFile(path) as file:
        ours = sv.read(file, time=1)
    # Who asks for a time point is not warned that it is read.
    with warnings.catch_warnings():
        warnings.simplefilter("error", sv.DataWarning)
        theirs = sv.read(path, time=1)
    with pytest.warns(sv.DataWarning, match="time point 0 of 2"):
        sv.read(path)
    assert isinstance(ours, sv.Volume) and isinstance(theirs, sv.Volume)
    assert (ours.spacing, ours.unit) == (theirs.spacing, theirs.unit) == ((2.0, 0.25, 0.5), "um")
    np.testing.assert_array_equal(np.asarray(ours), np.asarray(theirs))


def test_pages_and_memory_maps(ball: np.ndarray, tmp_path: Path) -> None:
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "stack.tif"
    tifffile.imwrite(path, ball, photometric="minisblack", metadata=None)
    with tifffile.TiffFile(path) as file:
        np.testing.assert_array_equal(np.asarray(sv.read(file)), ball)
        np.testing.assert_array_equal(np.asarray(sv.read(file.pages[7])), ball[7:8])
    assert sv.Volume(tifffile.memmap(path, mode="r")).is_shared
    colours = tmp_path / "colours.tif"
    tifffile.imwrite(colours, np.zeros((8, 8, 3), np.uint8), photometric="rgb")
    with tifffile.TiffFile(colours) as file, pytest.raises(sv.InvalidValue, match="colours"):
        sv.read(file)
