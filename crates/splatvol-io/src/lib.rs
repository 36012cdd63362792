//! Readers and writers: volumes, transfer functions and images.
