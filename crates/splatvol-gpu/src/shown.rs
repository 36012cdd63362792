//! Shown: volumes and meshes in their places with their looks, and what their data on the device depend on.

use std::sync::{Arc, Weak};

use splatvol_core::classification::ClassificationTable;
use splatvol_core::engine::Shot;
use splatvol_core::level::{Detail, VolumeLook, Wanted};
use splatvol_core::plan::Sampling;
use splatvol_core::refine::finest_grid;
use splatvol_core::scene_cloud;
use splatvol_core::shade_table::ShadeTable;
use splatvol_core::visibility::VisibleLevels;
use splatvol_scene::{
    Camera, Gradient, RenderSettings, Scene, SheetKernel, SheetSettings, Shows, TransferFunction, Volume,
};

use crate::check::DrawnMesh;
use crate::clouds::{Look, OfMesh, ValueLook};
use crate::effects::Effects;
use crate::mode::{Kept, Mode, nodes};

/// The layers of a scene where they lie.
#[derive(Debug)]
pub(crate) struct Placed<'a> {
    pub shown: Vec<Shown<'a>>,
    pub meshes: Vec<ShownMesh<'a>>,
    /// Everything that is classified before it is splatted.
    pub rest: Scene,
    /// Clips of that.
    pub clips: Effects,
    pub sheets: RenderSettings<SheetSettings>,
}

impl Placed<'_> {
    pub(crate) fn has_clouds(&self) -> bool {
        !self.meshes.is_empty() || !self.rest.items.is_empty()
    }

    /// Whether layers are composited together.
    pub(crate) fn gathers(&self) -> bool {
        let composites = matches!(self.sheets.method.shows, Shows::Material(_));
        composites && (self.shown.len() > 1 || self.has_clouds())
    }

    /// Whether clouds are added up to X-rays, without planes.
    pub(crate) fn integrates_clouds(&self) -> bool {
        self.sheets.method.shows == Shows::Xray && self.has_clouds()
    }

    /// Looks of the meshes, then of the rest, on planes.
    pub(crate) fn looks(&self) -> Vec<Look<'_>> {
        if self.integrates_clouds() {
            return Vec::new();
        }
        let meshes = self.meshes.iter().map(ShownMesh::look);
        let rest = (!self.rest.items.is_empty()).then_some(Look::Colors { clips: &self.clips });
        meshes.chain(rest).collect()
    }
}

/// A post-classified mesh where it lies, and its look.
#[derive(Debug)]
pub(crate) struct ShownMesh<'a> {
    of: OfMesh<'a>,
    table: ShadeTable,
    effects: Effects,
    /// Where each ray shows one of its values.
    values: Option<ValueLook>,
}

impl<'a> ShownMesh<'a> {
    pub(crate) fn new(
        drawn: &DrawnMesh<'a>,
        shot: &Shot<'_>,
        sheets: &RenderSettings<SheetSettings>,
    ) -> Self {
        let DrawnMesh {
            item,
            mesh,
            transfer_function,
            isosurfaces,
        } = *drawn;
        let spacing = scene_cloud::spacing(item);
        // Opacities refer to lengths of the item's own world.
        let own = transfer_function.unit_distance;
        let unit_distance = own.map_or(spacing, |distance| distance * item.scale());
        let range = mesh.value_range().map(f64::from);
        let classified = ClassificationTable::new(transfer_function, range, unit_distance);
        let mut table = ShadeTable::default();
        table.update(&classified, &VisibleLevels::new(&classified), 0.0);
        // Beside the mesh there is nothing, whatever its values.
        table.shows_background = false;
        let values = Kept::of(Wanted::of(sheets)).map(|kept| ValueLook {
            kept,
            nodes: nodes(&classified),
            unit_distance: unit_distance as f32,
        });
        Self {
            values,
            of: OfMesh {
                mesh,
                world_from_local: item.world_from_item * *mesh.world_from_local(),
                spacing,
            },
            table,
            effects: Effects::new((shot.scene, item, isosurfaces), shot.camera, (range, spacing)),
        }
    }

    pub(crate) fn cloud(&self) -> OfMesh<'a> {
        self.of
    }

    fn look(&self) -> Look<'_> {
        let (table, effects) = (&self.table, &self.effects);
        match &self.values {
            None => Look::Field { table, effects },
            Some(values) => Look::Values { table, values },
        }
    }
}

/// A volume where it lies, and its look.
#[derive(Debug)]
pub(crate) struct Shown<'a> {
    pub volume: Arc<Volume>,
    pub transfer_function: &'a TransferFunction,
    pub unit_distance: f64,
    pub labels: bool,
    pub settings: RenderSettings<SheetSettings>,
    pub effects: Effects,
}

impl Shown<'_> {
    /// How its values are shown.
    pub(crate) fn look(&self) -> VolumeLook<'_> {
        VolumeLook {
            transfer_function: self.transfer_function,
            unit_distance: self.unit_distance,
            labels: self.labels,
        }
    }

    pub(crate) fn key(&self, level: usize) -> Key {
        Key {
            level,
            volume: Arc::downgrade(&self.volume),
            transfer_function: self.transfer_function.clone(),
            unit_distance: self.unit_distance,
            labels: self.labels,
            kernel: self.settings.method.kernel,
            prefilter: self.settings.method.prefilter,
            wanted: Wanted::of(&self.settings),
        }
    }

    /// Voxels along an axis that the kernel meets.
    pub(crate) fn taps(&self) -> i32 {
        if self.settings.method.kernel.radius > 2.0 {
            6
        } else {
            4
        }
    }

    /// Whether the kernel ends nearer than the outermost of them can be.
    pub(crate) fn is_cut(&self) -> bool {
        2.0 * self.settings.method.kernel.radius < f64::from(self.taps())
    }

    pub(crate) fn mode(&self) -> Mode {
        Mode::of(Wanted::of(&self.settings), &self.settings.method, &self.effects)
    }

    /// Whether it has levels of detail. Analytic gradients show the field as it is, and have none.
    pub(crate) fn has_levels(&self) -> bool {
        self.mode().splats_classes() || self.settings.method.gradient != Gradient::Analytic
    }

    /// Its level of detail.
    pub(crate) fn detail(&self, camera: &Camera) -> Detail {
        match self.has_levels() {
            true => Detail::new(
                &finest_grid(&self.volume, &self.settings),
                camera,
                (self.settings.size, self.settings.method.level_bias),
            ),
            false => Detail::FINEST,
        }
    }

    /// How its voxels are sampled.
    pub(crate) fn sampling(&self) -> Sampling {
        match self.mode().splats_classes() {
            true => Sampling::Planes,
            false => Sampling::Field,
        }
    }
}

/// What a volume's needed voxels depend on.
#[derive(Debug, Clone)]
pub(crate) struct Key {
    pub level: usize,
    pub volume: Weak<Volume>,
    transfer_function: TransferFunction,
    unit_distance: f64,
    labels: bool,
    kernel: SheetKernel,
    prefilter: bool,
    wanted: Wanted,
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.is_like(other)
            && self.level == other.level
            && self.transfer_function == other.transfer_function
            && self.unit_distance == other.unit_distance
    }
}

impl Key {
    /// Whether another is of the same but for the level and the look.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.volume, &other.volume)
            && self.kernel == other.kernel
            && self.prefilter == other.prefilter
            && self.wanted == other.wanted
            && self.labels == other.labels
    }
}
