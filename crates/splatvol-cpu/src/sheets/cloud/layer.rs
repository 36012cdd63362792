//! Clouds and meshes as layers of a scene.

use splatvol_core::bin::TileGrid;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::plan::Rays;
use splatvol_core::splats::SplatCloud;
use splatvol_core::visibility::VisibleLevels;
use splatvol_scene::{Camera, Clip, RenderSettings, SheetSettings, TransferFunction};

use super::emission::EmittedLight;
use super::field::FieldMaterial;
use super::mode::CloudMode;
use super::plan::CloudPlan;
use super::values::MeshValues;
use crate::phong::Phong;
use crate::route::MeshScene;
use crate::sheets::frame::ZonedFrame;
use crate::sheets::intensity::{RayValues, Reduction, ValueColors};
use crate::sheets::layers::Layer;
use crate::sheets::operated::Operated;
use crate::sheets::shade::PlaneShader;
use splatvol_core::border::Border;
use splatvol_core::shade_table::ShadeTable;

impl CloudPlan {
    /// The layer of a cloud of classified splats, cut by clips (world).
    pub(crate) fn layer<'a>(
        &'a mut self,
        (cloud, clips): (&'a SplatCloud, &[Clip]),
        view: (&Camera, &RenderSettings<SheetSettings>),
        tiles: TileGrid,
        spacing: Option<f64>,
    ) -> Layer<'a> {
        let (frame, view) = self.frame(cloud, view, tiles, spacing);
        let view = view.cut(clips);
        let shading = EmittedLight;
        Layer::Cloud(frame, CloudMode { view, shading })
    }
}

/// Cached data of a mesh's layer, kept between frames.
#[derive(Debug, Default)]
pub(crate) struct MeshLayer {
    plan: CloudPlan,
    table: ShadeTable,
    classified: Option<ClassifiedValues>,
}

/// Values of a mesh, classified.
#[derive(Debug)]
struct ClassifiedValues {
    table: ClassificationTable,
    /// Cache key: colours and opacities, the length to which those refer, and the values' range.
    made_for: (TransferFunction, f64, [f32; 2]),
}

impl ClassifiedValues {
    fn new(mesh: &MeshScene<'_>) -> Self {
        let (own, unit_distance) = (mesh.transfer_function, mesh.unit_distance);
        let range = mesh.mesh.value_range();
        Self {
            table: ClassificationTable::new(own, range.map(f64::from), unit_distance),
            made_for: (own.clone(), unit_distance, range),
        }
    }

    fn is_of(&self, mesh: &MeshScene<'_>) -> bool {
        let (own, unit_distance, range) = &self.made_for;
        (own, *unit_distance, *range)
            == (
                mesh.transfer_function,
                mesh.unit_distance,
                mesh.mesh.value_range(),
            )
    }
}

/// A mesh, and its samples.
type OfMesh<'a> = (&'a SplatCloud, &'a MeshScene<'a>);

impl MeshLayer {
    /// Classifies the values of a mesh.
    fn classify(&mut self, mesh: &MeshScene<'_>) {
        self.classified.take_if(|classified| !classified.is_of(mesh));
        if self.classified.is_none() {
            let classified = ClassifiedValues::new(mesh);
            let visible = VisibleLevels::new(&classified.table);
            self.table.update(&classified.table, &visible, 0.0);
            // Beside the mesh there is nothing, whatever its values.
            self.table.shows_background = false;
            self.classified = Some(classified);
        }
    }

    /// The layer of a mesh.
    pub(crate) fn layer<'a>(
        &'a mut self,
        (cloud, mesh): OfMesh<'a>,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        tiles: TileGrid,
        spacing: Option<f64>,
    ) -> Layer<'a> {
        self.classify(mesh);
        let (frame, view) = self.plan.frame(cloud, (camera, settings), tiles, spacing);
        let range = mesh.mesh.value_range().map(f64::from);
        let shading = FieldMaterial {
            shader: shader(&frame, &self.table, (mesh, settings)),
            operated: Operated::new(&mesh.effects, mesh.spacing, (camera, range)),
        };
        Layer::Mesh(frame, Box::new(CloudMode { view, shading }))
    }

    /// The layer of a mesh with one value per ray.
    pub(crate) fn values<'a, K: Reduction>(
        &'a mut self,
        (cloud, mesh): OfMesh<'a>,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        tiles: TileGrid,
    ) -> Option<(ZonedFrame<'a>, CloudMode<'a, MeshValues<'a, K>>)> {
        self.classify(mesh);
        let table = &self.classified.as_ref()?.table;
        let (frame, view) = self.plan.frame(cloud, (camera, settings), tiles, None);
        let shader = shader(&frame, &self.table, (mesh, settings));
        let colors = ValueColors::new(table, mesh.unit_distance);
        let shading = MeshValues(RayValues::new(shader, colors));
        Some((frame, CloudMode { view, shading }))
    }
}

/// Shader for the planes of a mesh's frame.
fn shader<'a>(
    frame: &ZonedFrame<'_>,
    table: &'a ShadeTable,
    (mesh, settings): (&MeshScene<'_>, &RenderSettings<SheetSettings>),
) -> PlaneShader<'a> {
    let Rays {
        principal,
        per_pixel,
        plane_per_pixel,
    } = frame.plan.rays;
    PlaneShader {
        table,
        phong: settings.lighting.as_ref().map(|l| Phong::new(l, mesh.spacing)),
        spacing: frame.plan.zones()[0].zone.planes.spacing as f32,
        background: 0.0,
        principal,
        per_pixel,
        plane_per_pixel,
        termination: settings.termination as f32,
        border: Border::nowhere(),
    }
}
