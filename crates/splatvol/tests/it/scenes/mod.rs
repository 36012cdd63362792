//! Scenes of several things, and of one: surfels, Gaussians, meshes and volumes.

mod ellipsoids;
mod gaussians;
mod labels;
mod layers;
mod mesh_values;
mod meshes;
mod mixed;
mod single;
mod support;
mod surfels;
mod table;
