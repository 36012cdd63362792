//! PLOT3D as text, and of two dimensions, written here.

use std::fmt::Write;
use std::path::Path;

use splatvol_io::{DataKind, DataOptions, ReadOptions, data_kind, is_mesh, is_plot3d_pair, read_mesh};
use splatvol_scene::Topology;

use super::read;

/// What is written: 4 x 3 x 2 points, or 4 x 3 on a plane.
#[derive(Clone, Copy, Debug)]
struct Style {
    several: bool,
    plane: bool,
    blanked: bool,
    /// Columns of a line.
    columns: usize,
}

impl Style {
    const ALL: u8 = 8;

    fn of(bits: u8) -> Self {
        let [several, plane, blanked] = [0, 1, 2].map(|bit| bits >> bit & 1 == 1);
        Self {
            several,
            plane,
            blanked,
            columns: 5,
        }
    }

    fn dims(self) -> [usize; 3] {
        [4, 3, if self.plane { 1 } else { 2 }]
    }

    fn blocks(self) -> usize {
        if self.several { 2 } else { 1 }
    }

    fn points(self) -> usize {
        self.dims().iter().product()
    }

    fn axes(self) -> usize {
        if self.plane { 2 } else { 3 }
    }

    fn head(self) -> Vec<String> {
        let count = self.several.then(|| "2".to_owned());
        let dims = self.dims()[..self.axes()].repeat(self.blocks());
        count
            .into_iter()
            .chain(dims.iter().map(usize::to_string))
            .collect()
    }

    fn grid(self) -> String {
        let mut words = self.head();
        for block in 0..self.blocks() {
            for axis in 0..self.axes() {
                let at = |n: usize| [n % 4 + 10 * block, n / 4 % 3, n / 12][axis];
                // Fortran's double precision, among others.
                words.extend((0..self.points()).map(|n| format!("{}.0D0", at(n))));
            }
            if self.blanked {
                words.extend((0..self.points()).map(|n| i32::from(n != 5).to_string()));
            }
        }
        self.lines(&words)
    }

    fn solution(self) -> String {
        let mut words = self.head();
        for _ in 0..self.blocks() {
            words.extend(["0.5", "0", "1e4", "0"].map(str::to_owned));
            // rho = 2, momentum (6, 8) or (6, 0, 8), e = n: pressure 0.4 (n - 25).
            let momentum: &[&str] = if self.plane { &["6", "8"] } else { &["6", "0", "8"] };
            let constants = std::iter::once("2").chain(momentum.iter().copied());
            words.extend(constants.flat_map(|value| vec![value.to_owned(); self.points()]));
            words.extend((0..self.points()).map(|n| n.to_string()));
        }
        self.lines(&words)
    }

    fn lines(self, words: &[String]) -> String {
        let mut text = String::new();
        for line in words.chunks(self.columns) {
            writeln!(text, " {}", line.join("  ")).unwrap();
        }
        text
    }

    fn write(self, folder: &Path) -> [std::path::PathBuf; 2] {
        let paths = ["a.xyz", "a.q"].map(|name| folder.join(name));
        std::fs::write(&paths[0], self.grid()).unwrap();
        std::fs::write(&paths[1], self.solution()).unwrap();
        paths
    }
}

#[test]
fn text_is_read_in_every_layout() {
    for bits in 0..Style::ALL {
        let style = Style::of(bits);
        let folder = tempfile::tempdir().unwrap();
        let [grid, solution] = style.write(folder.path());
        assert!(
            is_mesh(&grid).unwrap() && is_mesh(&solution).unwrap(),
            "{style:?}"
        );
        assert!(
            is_plot3d_pair(&grid, &solution) && !is_plot3d_pair(&solution, &grid),
            "{style:?}"
        );
        let loaded = read(&grid, Some("pressure"));
        let mesh = loaded.mesh;
        // A plane becomes a layer.
        assert_eq!(
            mesh.topology(),
            &Topology::Structured(vec![[4, 3, 2]; style.blocks()]),
            "{style:?}"
        );
        let pressure = 0.4f32 * (10.0 - 25.0);
        assert_eq!(
            mesh.field().values[24 * (style.blocks() - 1) + 10],
            pressure,
            "{style:?}"
        );
        let shown: Vec<bool> = match (style.blanked, style.plane) {
            (false, _) => Vec::new(),
            (true, true) => (0..24 * style.blocks()).map(|n| n % 12 == 5).collect(),
            (true, false) => (0..24 * style.blocks()).map(|n| n % 24 == 5).collect(),
        };
        assert_eq!(mesh.blanked(), shown, "{style:?}");
        let far = if style.several { 13.0 } else { 3.0 };
        assert_eq!(
            [mesh.bounds().min.x, mesh.bounds().max.x],
            [0.0, far],
            "{style:?}"
        );
        let grids = style.blocks();
        assert_eq!(loaded.description.stored_type, format!("text, {grids} grid(s)"));
    }
}

#[test]
fn tables_of_text_stay_tables() {
    let folder = tempfile::tempdir().unwrap();
    let kind = |path: &Path, options: &DataOptions| data_kind(path, options).unwrap();
    let path = folder.path().join("a.xyz");
    let automatic = DataOptions::default();
    // Nine points, the first of which could be the dimensions of the others.
    let rows: String = (0..8).map(|n| format!("{n} 0.5 {n}.25\n")).collect();
    std::fs::write(&path, format!("2 2 2\n{rows}")).unwrap();
    assert_eq!(kind(&path, &automatic), DataKind::Points);
    std::fs::write(&path, format!("8\n{rows}")).unwrap();
    assert_eq!(kind(&path, &automatic), DataKind::Points);
    // A grid of three columns is one if its solution lies beside it, or is named.
    let style = Style {
        columns: 3,
        ..Style::of(0)
    };
    let [grid, solution] = style.write(folder.path());
    assert_eq!(kind(&grid, &automatic), DataKind::Mesh);
    let elsewhere = folder.path().join("flow.q");
    std::fs::rename(&solution, &elsewhere).unwrap();
    assert_eq!(kind(&grid, &automatic), DataKind::Points);
    let named = DataOptions {
        read: ReadOptions {
            solution: Some(elsewhere),
            ..ReadOptions::default()
        },
        ..DataOptions::default()
    };
    assert_eq!(kind(&grid, &named), DataKind::Mesh);
    assert_eq!(read_mesh(&grid, &named.read).unwrap().mesh.positions().len(), 24);
    // Names that are not PLOT3D's are never taken for it.
    std::fs::rename(&grid, folder.path().join("a.txt")).unwrap();
    assert!(!is_mesh(folder.path().join("a.txt")).unwrap());
}

#[test]
fn broken_text_is_refused_by_its_word() {
    let folder = tempfile::tempdir().unwrap();
    let style = Style::of(0);
    let [grid, _] = style.write(folder.path());
    let refused = |text: &str, why: &str| {
        std::fs::write(&grid, text).unwrap();
        let options = ReadOptions {
            solution: Some(folder.path().join("a.q")),
            ..ReadOptions::default()
        };
        let error = read_mesh(&grid, &options).unwrap_err().to_string();
        assert!(error.contains(why) && error.contains("a.xyz"), "{error}");
    };
    refused(&style.grid().replacen("3.0D0", "north", 1), "north");
    refused(&style.grid().replacen("3.0D0", "", 1), "74");
    refused(&style.grid().replacen("3.0D0", "nan", 1), "finite");
    refused("2000000000 2000000000 2000000000 1 2 3", "6");
}

/// Two dimensions in binary files.
#[test]
fn planes_are_read_from_binary_files_too() {
    let folder = tempfile::tempdir().unwrap();
    let words = |text: &str, wholes: usize| -> Vec<u8> {
        let words = text.split_whitespace().enumerate();
        let bytes = words.map(|(index, word)| match index < wholes {
            true => word.parse::<i32>().unwrap().to_le_bytes(),
            false => word.replace("D0", "").parse::<f32>().unwrap().to_le_bytes(),
        });
        bytes.flatten().collect()
    };
    let style = Style::of(2);
    let [grid, solution] = style.write(folder.path());
    std::fs::write(&grid, words(&style.grid(), 2)).unwrap();
    std::fs::write(&solution, words(&style.solution(), 2)).unwrap();
    let mesh = read(&solution, Some("velocity:magnitude")).mesh;
    assert_eq!(mesh.topology(), &Topology::Structured(vec![[4, 3, 2]]));
    assert_eq!(mesh.field().values[7], 5.0);
    // Elsewhere two whole numbers at the start prove nothing.
    std::fs::rename(&grid, folder.path().join("a.dat")).unwrap();
    assert!(!is_mesh(folder.path().join("a.dat")).unwrap());
}
