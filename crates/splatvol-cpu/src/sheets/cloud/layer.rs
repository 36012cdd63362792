//! Clouds and meshes as layers of a scene.

use splatvol_core::bin::TileGrid;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::plan::Rays;
use splatvol_core::splats::SplatCloud;
use splatvol_core::visibility::VisibleLevels;
use splatvol_scene::{Camera, Clip, RenderSettings, TransferFunction};

use super::emission::CloudEmission;
use super::field::CloudField;
use super::plan::CloudPlan;
use crate::phong::Phong;
use crate::route::MeshScene;
use crate::sheets::border::Border;
use crate::sheets::layers::Layer;
use crate::sheets::operated::Operated;
use crate::sheets::shade::PlaneShader;
use crate::sheets::table::ShadeTable;

impl CloudPlan {
    /// The layer of a cloud of classified splats, of what clips (world) leave of it.
    pub(crate) fn layer<'a>(
        &'a mut self,
        (cloud, clips): (&'a SplatCloud, &[Clip]),
        view: (&Camera, &RenderSettings),
        tiles: TileGrid,
        spacing: Option<f64>,
    ) -> Layer<'a> {
        let (frame, view) = self.frame(cloud, view, tiles, spacing);
        let view = view.cut(clips);
        Layer::Cloud(frame, CloudEmission { view })
    }
}

/// What is kept of a mesh's layer between frames.
#[derive(Debug, Default)]
pub(crate) struct MeshLayer {
    plan: CloudPlan,
    table: ShadeTable,
    /// What the table was made for: colours and opacities, the length to which those refer, and the values' range.
    made_for: Option<(TransferFunction, f64, [f32; 2])>,
}

impl MeshLayer {
    /// Classifies the values of a mesh.
    fn classify(&mut self, mesh: &MeshScene<'_>) {
        let (own, unit_distance) = (mesh.transfer_function, mesh.unit_distance);
        let range = mesh.mesh.value_range();
        let same = |made: &(TransferFunction, f64, [f32; 2])| {
            (&made.0, made.1, made.2) == (own, unit_distance, range)
        };
        if self.made_for.as_ref().is_some_and(same) {
            return;
        }
        let table = ClassificationTable::new(own, range.map(f64::from), unit_distance);
        self.table.update(&table, &VisibleLevels::new(&table), 0.0);
        // Beside the mesh there is nothing, whatever its values.
        self.table.shows_background = false;
        self.made_for = Some((own.clone(), unit_distance, range));
    }

    /// The layer of a mesh, given its samples.
    pub(crate) fn layer<'a>(
        &'a mut self,
        (cloud, mesh): (&'a SplatCloud, &MeshScene<'a>),
        (camera, settings): (&Camera, &RenderSettings),
        tiles: TileGrid,
        spacing: Option<f64>,
    ) -> Layer<'a> {
        self.classify(mesh);
        let (frame, view) = self.plan.frame(cloud, (camera, settings), tiles, spacing);
        let Rays {
            principal,
            per_pixel,
            plane_per_pixel,
        } = frame.plan.rays;
        let shader = PlaneShader {
            table: &self.table,
            phong: settings.lighting.as_ref().map(|l| Phong::new(l, mesh.spacing)),
            spacing: frame.plan.zones()[0].zone.planes.spacing as f32,
            background: 0.0,
            principal,
            per_pixel,
            plane_per_pixel,
            termination: settings.termination as f32,
            border: Border::nowhere(),
        };
        let range = mesh.mesh.value_range().map(f64::from);
        let operated = Operated::new(&mesh.asked, mesh.spacing, (camera, range));
        let mode = CloudField {
            view,
            shader,
            operated,
        };
        Layer::Mesh(frame, Box::new(mode))
    }
}
