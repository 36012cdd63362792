"""How far a picture is from its reference: 8-bit display values, over the whole frame."""

import math

import numpy as np
from skimage.metrics import structural_similarity


def measure(picture, reference, mask=None):
    """PSNR in dB and SSIM (Wang 2004: Gaussian of 1.5 pixels, mean of the channels), over the pixels of `mask`."""
    if mask is None:
        mask = np.ones(picture.shape[:2], bool)
    error = picture[mask].astype(float) - reference[mask].astype(float)
    mean_square = float((error**2).mean())
    _, similarity = structural_similarity(
        picture, reference, data_range=255, channel_axis=2, gaussian_weights=True, sigma=1.5,
        use_sample_covariance=False, full=True)
    return {
        "psnr_db": 10 * math.log10(255**2 / mean_square) if mean_square else math.inf,
        "ssim": float(similarity[mask].mean()),
    }
