//! Extract: one cloud of all kernels of a scene, which engines keep between frames, until an item, its look or its place
//! has changed. Sheets and whole splats use the same cloud.
//!
//! Volumes and meshes are classified, points without radii or normals get estimated ones, and Gaussians get their
//! colours in this view.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use splatvol_scene::gaussians::harmonics_count;
use splatvol_scene::{
    Camera, Content, Gaussians, Item, Mesh, PointAttributes, PointLook, Points, Projection, RenderSettings,
    Scene, SheetSettings, TransferFunction, Volume, harmonics,
};

use crate::brick::BrickGrid;
use crate::classification::ClassificationTable;
use crate::coefficients::{Coefficients, Use};
use crate::engine::GoOn;
use crate::irregular;
use crate::points::{Neighborhoods, Orientation};
use crate::splats::{self, Extract, Gather, Gathered, KernelShape, Splat, SplatCloud, gaussian_payload};

/// Number of neighbours for the estimation of radii and normals.
const NEIGHBORS: usize = 8;
/// Most spacings along a scene's box, however fine one of its items is.
const MOST_SPACINGS: f64 = 8192.0;

/// The cloud of a scene.
#[derive(Debug)]
pub struct SceneCloud {
    items: Vec<Item>,
    key: (KernelShape, bool),
    gathered: Gathered,
    /// The Gaussians' items, and where their splats begin.
    colored: Vec<(usize, Item)>,
    /// Camera for which the Gaussians are coloured.
    camera: Option<Camera>,
}

/// What a cloud depends on beside its items: the kernels of voxels, and whether it is lit.
fn key(settings: &RenderSettings) -> (KernelShape, bool) {
    let own = settings.method.kernel().gaussian();
    let sigma = own.map_or(1.0, |(sigma, _)| sigma);
    (KernelShape::Sphere { sigma }, settings.lighting.is_some())
}

impl SceneCloud {
    /// The cloud of a scene, Gaussians without colours yet; `None` if it is given up meanwhile.
    pub fn new(scene: Scene, settings: &RenderSettings, go_on: GoOn<'_>) -> Option<Self> {
        let key = key(settings);
        let mut completed = Vec::new();
        for item in &scene.items {
            go_on().then_some(())?;
            completed.push(self::completed(item, key.1, go_on)?);
        }
        let bounds = scene.bounds().ok();
        let extent = bounds.map_or(0.0, |b| b.diagonal());
        let finest = completed.iter().map(spacing).filter(|s| *s > 0.0);
        let spacing = finest.reduce(f64::min).unwrap_or(1.0);
        let origin = bounds.map_or(DVec3::ZERO, |b| b.centre());
        let mut gather = Gather::around(origin, spacing.max(extent / MOST_SPACINGS));
        let (gaussians, others): (Vec<_>, Vec<_>) = completed
            .into_iter()
            .partition(|item| matches!(item.content, Content::Gaussians(_)));
        // Item by item: what was estimated of one is not needed for the next.
        for item in others {
            go_on().then_some(())?;
            add(&mut gather, &item, key, go_on)?;
        }
        let mut colored = Vec::new();
        for item in gaussians {
            go_on().then_some(())?;
            let first = gather.len();
            if let Content::Gaussians(gaussians) = &item.content {
                gather.add_gaussians(gaussians, &item.world_from_item, |_| [0.0; 3]);
                colored.push((first, item));
            }
        }
        let gathered = gather.finish_while(go_on)?;
        go_on().then(|| Self {
            items: scene.items,
            key,
            gathered,
            colored,
            camera: None,
        })
    }

    /// Whether it is that of a scene with these settings.
    pub fn is_of(&self, scene: &Scene, settings: &RenderSettings) -> bool {
        self.key == key(settings)
            && self.items.len() == scene.items.len()
            && self.items.iter().zip(&scene.items).all(|(a, b)| a.is_same(b))
    }

    /// The splats.
    pub fn cloud(&self) -> &SplatCloud {
        &self.gathered.cloud
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let Gathered { cloud, sources } = &self.gathered;
        cloud.bytes() + sources.capacity() * size_of::<u32>()
    }

    /// Sets the Gaussians' colours for this camera; returns whether they changed.
    pub fn color(&mut self, camera: &Camera) -> bool {
        if self.camera.as_ref() == Some(camera) || self.colored.is_empty() {
            return false;
        }
        let views: Vec<(usize, ColorView<'_>)> = self
            .colored
            .iter()
            .filter_map(|(first, item)| Some((*first, ColorView::new(item, camera)?)))
            .collect();
        let Gathered { cloud, sources } = &mut self.gathered;
        let from = cloud.peaks_from;
        cloud.payloads[from..]
            .par_iter_mut()
            .zip(&sources[from..])
            .for_each(|(payload, &source)| {
                let source = source as usize;
                let item = views.partition_point(|(first, _)| *first <= source);
                if let Some((first, view)) = item.checked_sub(1).map(|item| &views[item]) {
                    *payload = view.payload(source - first);
                }
            });
        self.camera = Some(*camera);
        true
    }
}

/// Whether the samples of a mesh are a post-classified layer.
pub fn is_post_classified(item: &Item, sheets: &SheetSettings) -> bool {
    matches!(item.content, Content::Mesh { .. }) && !sheets.splats_colors()
}

/// An item with radii for its points, and normals where they are lit.
fn completed(item: &Item, lit: bool, go_on: GoOn<'_>) -> Option<Item> {
    let Content::Points { points, look } = &item.content else {
        return Some(item.clone());
    };
    let own = points.attributes();
    let (radii, normals) = (!own.radii.is_empty(), !own.normals.is_empty() || !lit);
    if radii && normals && look.radius.is_none() {
        return Some(item.clone());
    }
    let up = (item.world_from_item * *points.world_from_local())
        .matrix3
        .inverse()
        * DVec3::Z;
    let neighbors = (!normals || (!radii && look.radius.is_none()))
        .then(|| Neighborhoods::new(points.positions(), NEIGHBORS));
    go_on().then_some(())?;
    let attributes = PointAttributes {
        colors: own.colors.clone(),
        normals: match &neighbors {
            Some(neighbors) if !normals => neighbors.normals(Orientation::of(points.positions(), up)),
            _ => own.normals.clone(),
        },
        radii: match (look.radius, &neighbors) {
            (Some(radius), _) => vec![radius as f32; points.len()],
            (None, Some(neighbors)) if !radii => neighbors.radii(),
            _ => own.radii.clone(),
        },
    };
    // Estimates are as valid as attributes from a file, except where all points are in one place: nothing is seen then.
    let points = Points::clone(points).with_attributes(attributes);
    Some(match points {
        Ok(points) => Item {
            content: Content::Points {
                points: points.into(),
                look: *look,
            },
            ..item.clone()
        },
        Err(_) => item.clone(),
    })
}

/// Distance between an item's samples, world length; zero where it is unknown.
pub fn spacing(item: &Item) -> f64 {
    let scale = |frame: &DAffine3| libm::cbrt(frame.matrix3.determinant().abs());
    let placed = scale(&item.world_from_item);
    match &item.content {
        Content::Volume { volume, .. } => volume.grid().mean_spacing() * placed,
        Content::Mesh { mesh, .. } => mesh.mean_spacing() * placed,
        Content::Points { points, .. } => {
            let radius = median(points.attributes().radii.clone());
            radius * scale(points.world_from_local()) * placed
        }
        Content::Gaussians(gaussians) => {
            // The mean of their longest axes: the long ones are cut by many sheets, and what that costs counts.
            let longest = |axes: &[f32; 3]| f64::from(axes[0].max(axes[1]).max(axes[2]));
            let scales = &gaussians.attributes().scales;
            let mean = scales.iter().map(longest).sum::<f64>() / scales.len().max(1) as f64;
            mean * scale(gaussians.world_from_local()) * placed
        }
    }
}

/// The median; zero for an empty list.
fn median(mut values: Vec<f32>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

fn add(gather: &mut Gather, item: &Item, (shape, lit): (KernelShape, bool), go_on: GoOn<'_>) -> Option<()> {
    match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            ..
        } => {
            let mut cloud = classified(volume, transfer_function, (shape, lit), go_on)?;
            let scale = item.world_from_item.matrix3.determinant().abs();
            cloud.world_from_local = item.world_from_item * cloud.world_from_local;
            cloud.mass *= scale;
            cloud.spacing *= libm::cbrt(scale);
            // Opacities refer to lengths of the volume's own world.
            let thinner = libm::cbrt(scale).recip() as f32;
            for payload in &mut cloud.payloads {
                *payload = payload.map(|value| value * thinner);
            }
            gather.add_voxels(&cloud);
        }
        Content::Points { points, look } => {
            let PointLook { color, opacity, .. } = *look;
            gather.add_points(points, &item.world_from_item, (color, opacity));
        }
        Content::Mesh {
            mesh,
            transfer_function,
            ..
        } => add_mesh(gather, item, (mesh, transfer_function), shape.sigma()),
        Content::Gaussians(_) => {}
    }
    Some(())
}

/// The visible samples of a mesh.
fn add_mesh(
    gather: &mut Gather,
    item: &Item,
    (mesh, transfer_function): (&Mesh, &TransferFunction),
    sigma: f64,
) {
    let kernels = irregular::kernels(mesh, sigma);
    let [low, high] = mesh.value_range().map(f64::from);
    let width = if high > low { high - low } else { 1.0 };
    // As with volumes, opacities refer to lengths of the item's own world.
    let placed = libm::cbrt(item.world_from_item.matrix3.determinant().abs());
    let unit_distance = transfer_function
        .unit_distance
        .unwrap_or_else(|| spacing(item) / placed);
    let table = ClassificationTable::new(transfer_function, [low, high], unit_distance);
    let lit = |value: f32| table.at(((f64::from(value) - low) / width) as f32);
    let visible: Vec<u32> = (0..kernels.len() as u32)
        .filter(|&index| lit(kernels.values[index as usize])[0] > 0.0)
        .collect();
    let frame = item.world_from_item * *mesh.world_from_local();
    let volume = frame.matrix3.determinant().abs();
    let world_from_gradient = frame.matrix3.inverse().transpose();
    let compared = gather.spacing();
    gather.add_splats(visible.len(), |index| {
        let index = visible[index] as usize;
        let mass = f64::from(kernels.masses[index]) * volume;
        let [xx, xy, xz, yy, yz, zz] = kernels.covariances[index].map(f64::from);
        let covariance = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        let gradient = DVec3::from_array(kernels.gradients[index].map(f64::from)) / width;
        Splat {
            centre: frame.transform_point3(DVec3::from_array(kernels.positions[index].map(f64::from))),
            covariance: frame.matrix3 * covariance * frame.matrix3.transpose(),
            payload: lit(kernels.values[index]).map(|value| (f64::from(value) * mass / placed) as f32),
            // Gradients are compared with the sample's own size.
            gradient: world_from_gradient * gradient * (libm::cbrt(mass) / compared),
        }
    });
}

/// The visible voxels of a volume.
fn classified(
    volume: &Volume,
    transfer_function: &TransferFunction,
    (shape, lit): (KernelShape, bool),
    go_on: GoOn<'_>,
) -> Option<SplatCloud> {
    let (samples, bricks): (Coefficients, BrickGrid) = Coefficients::new(volume, Use::Samples);
    go_on().then_some(())?;
    let unit_distance = transfer_function
        .unit_distance
        .unwrap_or_else(|| volume.grid().mean_spacing());
    let table = ClassificationTable::new(transfer_function, volume.value_range(), unit_distance);
    let cloud = splats::classified(&Extract {
        grid: volume.grid(),
        samples: &samples,
        bricks: &bricks,
        table: &table,
        shape: KernelShape::Sphere { sigma: shape.sigma() },
        gradients: lit,
        interest: None,
    });
    go_on().then_some(())?;
    Some(cloud)
}

/// Gaussians from a camera.
struct ColorView<'a> {
    gaussians: &'a Gaussians,
    /// The eye (`Ok`), or the common direction of all rays (`Err`), local.
    from: Result<DVec3, DVec3>,
}

impl<'a> ColorView<'a> {
    fn new(item: &'a Item, camera: &Camera) -> Option<Self> {
        let Content::Gaussians(gaussians) = &item.content else {
            return None;
        };
        let local_from_world = (item.world_from_item * *gaussians.world_from_local()).inverse();
        let from = match camera.projection() {
            Projection::Perspective { .. } => Ok(local_from_world.transform_point3(camera.position())),
            Projection::Orthographic { .. } => {
                let forward = camera.camera_from_world().inverse().transform_vector3(DVec3::Z);
                Err(local_from_world.transform_vector3(forward))
            }
        };
        Some(Self { gaussians, from })
    }

    fn payload(&self, index: usize) -> [f32; 4] {
        let attributes = self.gaussians.attributes();
        let mean = DVec3::from_array(attributes.means[index].map(f64::from));
        let direction = match self.from {
            Ok(eye) => mean - eye,
            Err(forward) => forward,
        };
        let degree = self.gaussians.degree();
        let count = harmonics_count(degree);
        let own = &attributes.harmonics[index * count..(index + 1) * count];
        let direction = direction.normalize_or(DVec3::Z).as_vec3().to_array();
        gaussian_payload(
            attributes.opacities[index],
            harmonics::color(degree, own, direction),
        )
    }
}
