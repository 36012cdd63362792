//! What the engines share: kernels, prefilter, footprints, classification, culling.
