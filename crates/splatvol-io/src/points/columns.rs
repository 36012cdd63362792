//! Roles of table columns, by their customary names.

/// Role of a column, as the index into a row of [`Gather`](super::gather::Gather).
pub(super) const X: usize = 0;
pub(super) const NORMAL: usize = 3;
pub(super) const RED: usize = 6;
pub(super) const ALPHA: usize = 9;
pub(super) const INTENSITY: usize = 10;
pub(super) const RADIUS: usize = 11;
/// Number of roles.
pub(super) const ROLES: usize = 12;

/// Values of a point by role; NaN if there is none.
pub(super) type Row = [f64; ROLES];

/// Names of each role, lower case.
const NAMES: [&[&str]; ROLES] = [
    &["x", "px", "posx", "pos_x", "x_coord", "easting", "position_x"],
    &["y", "py", "posy", "pos_y", "y_coord", "northing", "position_y"],
    &[
        "z",
        "pz",
        "posz",
        "pos_z",
        "z_coord",
        "height",
        "elevation",
        "position_z",
    ],
    &["nx", "normal_x", "normalx", "n_x"],
    &["ny", "normal_y", "normaly", "n_y"],
    &["nz", "normal_z", "normalz", "n_z"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a", "diffuse_alpha"],
    &[
        "intensity",
        "i",
        "scalar_intensity",
        "reflectance",
        "gray",
        "grey",
    ],
    &["radius", "point_radius"],
];

/// The role of a column of this name.
pub(super) fn role(name: &str) -> Option<usize> {
    let name = name.trim().trim_matches(['"', '\'', '/']).to_ascii_lowercase();
    NAMES.iter().position(|names| names.contains(&name.as_str()))
}

/// The first column of each role.
pub(super) fn columns_of_roles<'a>(names: impl Iterator<Item = &'a str>) -> [Option<usize>; ROLES] {
    let mut columns = [None; ROLES];
    for (column, name) in names.enumerate() {
        if let Some(role) = role(name) {
            columns[role].get_or_insert(column);
        }
    }
    complete(columns)
}

/// Vectors that lack a component are left out.
pub(super) fn complete(mut columns: [Option<usize>; ROLES]) -> [Option<usize>; ROLES] {
    for first in [NORMAL, RED] {
        if columns[first..first + 3].iter().any(Option::is_none) {
            columns[first..first + 3].fill(None);
        }
    }
    if columns[RED].is_none() {
        columns[ALPHA] = None;
    }
    columns
}
