"""How a volume that splatvol read must agree with what another reader says."""

import itertools

import numpy as np

LPS_TO_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])


def corners(dims, affine):
    """World positions of the eight corner voxels."""
    ends = itertools.product(*[(0, size - 1) for size in dims])
    return np.array([(affine @ [*end, 1])[:3] for end in ends])


def compare(expected, actual, exact=True):
    """Raises AssertionError where two volumes differ. Values that are not `exact` may be rounded to f32."""
    assert actual.values.shape == expected.values.shape, (
        f"shape {actual.values.shape}, expected {expected.values.shape}"
    )
    if expected.ras_from_voxel is not None:
        compare_positions(expected, actual)
    compare_values(expected.values, actual.values, exact)
    compare_statistics(expected.values, actual)


def compare_positions(expected, actual):
    """Corners to 1e-5 of a voxel (headers hold f32 numbers), or 1e-6 of their distance from the origin."""
    dims = expected.values.shape[::-1]
    wanted = corners(dims, expected.ras_from_voxel)
    found = corners(dims, actual.ras_from_voxel)
    voxel = np.linalg.norm(expected.ras_from_voxel[:3, :3], axis=0).min()
    tolerance = max(1e-5 * voxel, 1e-6 * np.abs(wanted).max())
    error = np.abs(wanted - found).max()
    assert error <= tolerance, f"corners are off by {error:g}:\n{found}\nexpected\n{wanted}"


def compare_values(expected, actual, exact):
    """Every voxel, NaN where NaN is."""
    wanted, found = expected.astype(np.float64), actual.astype(np.float64)
    if exact:
        same = np.array_equal(wanted, found, equal_nan=True)
    else:
        scale = np.nanmax(np.abs(wanted), initial=0.0)
        same = np.allclose(wanted, found, rtol=1e-6, atol=1e-7 * scale, equal_nan=True)
    if not same:
        wrong = np.argwhere(~((wanted == found) | (np.isnan(wanted) & np.isnan(found))))
        first = tuple(wrong[0])
        raise AssertionError(
            f"{len(wrong)} of {wanted.size} voxels differ, first at zyx {first}:"
            f" {found[first]}, expected {wanted[first]}"
        )


def compare_statistics(expected, actual):
    """Range and mean that splatvol states, over finite values."""
    finite = expected.astype(np.float64)
    finite = finite[np.isfinite(finite)]
    scale = np.abs(finite).max(initial=1e-300)
    for name, wanted, found in [
        ("min", finite.min(), actual.minimum),
        ("max", finite.max(), actual.maximum),
        ("mean", finite.mean(), actual.mean),
    ]:
        if found is not None:
            assert abs(wanted - found) <= 1e-6 * scale, f"{name} is {found}, expected {wanted}"
