//! Extract: one cloud of all kernels of a scene, kept between frames, rebuilt when an item, its look or its place
//! has changed. Sheets (`sheets::cloud`) and whole splats (`splats`) use the same cloud.
//!
//! Volumes and meshes are classified, points without radii or normals get estimated ones, and Gaussians get their
//! colours in this view.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use splatvol_core::brick::BrickGrid;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::coefficients::{Coefficients, Use};
use splatvol_core::irregular;
use splatvol_core::points::{Neighborhoods, Orientation};
use splatvol_core::splats::{
    self, Extract, Gather, Gathered, KernelShape, Splat, SplatCloud, gaussian_payload,
};
use splatvol_scene::gaussians::harmonics_count;
use splatvol_scene::{
    Camera, Content, Gaussians, Item, Mesh, PointAttributes, PointLook, Points, Projection, RenderSettings,
    Scene, TransferFunction, Volume, harmonics,
};

use crate::prepare::Patience;
use crate::run::Run;

/// Number of neighbours for the estimation of radii and normals.
const NEIGHBORS: usize = 8;
/// Most spacings along a scene's box, however fine one of its items is.
const MOST_SPACINGS: f64 = 8192.0;

/// The cloud last made.
#[derive(Debug, Default)]
pub(crate) struct ItemStore {
    kept: Option<Kept>,
}

#[derive(Debug)]
struct Kept {
    items: Vec<Item>,
    key: (KernelShape, bool),
    gathered: Gathered,
    /// The Gaussians' items, and where their splats begin.
    colored: Vec<(usize, Item)>,
    /// Camera for which the Gaussians are coloured.
    camera: Option<Camera>,
}

impl ItemStore {
    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let sources = |kept: &Kept| kept.gathered.sources.capacity() * size_of::<u32>();
        self.kept
            .as_ref()
            .map_or(0, |kept| kept.gathered.cloud.bytes() + sources(kept))
    }

    /// The cloud of a scene in this camera's view; `None` if the picture is cancelled while the cloud is being
    /// made.
    pub(crate) fn cloud(
        &mut self,
        run: Run<'_>,
        scene: &Scene,
        (camera, settings): (&Camera, &RenderSettings),
    ) -> Option<&SplatCloud> {
        let sigma = settings
            .method
            .kernel()
            .gaussian()
            .map_or(1.0, |(sigma, _)| sigma);
        let key = (KernelShape::Sphere { sigma }, settings.lighting.is_some());
        let same = |kept: &Kept| {
            kept.key == key
                && kept.items.len() == scene.items.len()
                && kept.items.iter().zip(&scene.items).all(|(a, b)| a.is_same(b))
        };
        if !self.kept.as_ref().is_some_and(same) {
            // First, so that the memory of two clouds is never needed.
            self.kept = None;
        }
        if self.kept.is_none() {
            let scene = scene.clone();
            let made = run
                .pool
                .prepare(run.task.stop, move |patience| Kept::new(scene, key, patience))?;
            self.kept = Some(made);
        }
        let kept = self.kept.as_mut()?;
        run.pool.install(|| kept.color(camera));
        Some(&kept.gathered.cloud)
    }
}

impl Kept {
    fn new(scene: Scene, key: (KernelShape, bool), patience: &Patience) -> Option<Self> {
        let mut completed = Vec::new();
        for item in &scene.items {
            patience.go_on()?;
            completed.push(self::completed(item, key.1, patience)?);
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
            patience.go_on()?;
            add(&mut gather, &item, key, patience)?;
        }
        let mut colored = Vec::new();
        for item in gaussians {
            patience.go_on()?;
            let first = gather.len();
            if let Content::Gaussians(gaussians) = &item.content {
                gather.add_gaussians(gaussians, &item.world_from_item, |_| [0.0; 3]);
                colored.push((first, item));
            }
        }
        let gathered = gather.finish_while(|| patience.go_on().is_some())?;
        patience.go_on()?;
        Some(Self {
            items: scene.items,
            key,
            gathered,
            colored,
            camera: None,
        })
    }

    /// Sets the Gaussians' colours for this camera.
    fn color(&mut self, camera: &Camera) {
        if self.camera.as_ref() == Some(camera) || self.colored.is_empty() {
            return;
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
    }
}

/// An item with radii for its points, and normals where they are lit.
fn completed(item: &Item, lit: bool, patience: &Patience) -> Option<Item> {
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
    patience.go_on()?;
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
pub(crate) fn spacing(item: &Item) -> f64 {
    let scale = |frame: &DAffine3| libm::cbrt(frame.matrix3.determinant().abs());
    let placed = scale(&item.world_from_item);
    match &item.content {
        Content::Volume { volume, .. } => volume.grid().mean_spacing() * placed,
        Content::Mesh { mesh, .. } => {
            let size = mesh.bounds().max - mesh.bounds().min;
            let count = mesh.positions().len().max(1) as f64;
            libm::cbrt(size.x * size.y * size.z / count) * placed
        }
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

fn add(
    gather: &mut Gather,
    item: &Item,
    (shape, lit): (KernelShape, bool),
    patience: &Patience,
) -> Option<()> {
    match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            ..
        } => {
            let mut cloud = classified(volume, transfer_function, (shape, lit), patience)?;
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
    patience: &Patience,
) -> Option<SplatCloud> {
    let (samples, bricks): (Coefficients, BrickGrid) = Coefficients::new(volume, Use::Samples);
    patience.go_on()?;
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
    patience.go_on()?;
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
