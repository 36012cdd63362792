//! Flags as a document: every flag about the picture is a key.

use std::path::{Path, PathBuf};

use splatvol_document::Document;
use splatvol_document::keys::names::GaussianModeName;
use splatvol_document::keys::{
    AnimationKeys, CameraKeys, EffectKeys, ItemKeys, MotionKeys, Opacity, Parallel, PictureSize, SettingKeys,
};
use splatvol_io::Endian;

use super::{
    AnimateArgs, CameraArgs, EffectArgs, FastSplatsArgs, FootprintArgs, InputArgs, KernelArgs, LookArgs,
    MethodArgs, MotionArgs, PictureArgs, RenderArgs,
};

impl RenderArgs {
    /// The flags as a document. A scene file has items of its own, so it leaves none here.
    pub(crate) fn document(&self, item_file: Option<&str>) -> Document {
        self.picture.document(self.size, item_file)
    }
}

impl PictureArgs {
    /// The flags as a document of a size. A scene file has items of its own, so it leaves none here.
    pub(crate) fn document(&self, size: Option<PictureSize>, item_file: Option<&str>) -> Document {
        let item = self.item_keys(item_file.unwrap_or_default());
        let given = item != ItemKeys::default();
        Document {
            size,
            background: self.background,
            bits: self.bits,
            items: given.then_some(item).into_iter().collect(),
            camera: (&self.camera).into(),
            settings: self.method.keys(self.item.gaussians),
            effects: (&self.effects).into(),
            motion: (&self.motion).into(),
            ..Document::default()
        }
    }

    /// The keys of the item that the flags are about.
    pub(crate) fn item_keys(&self, file: &str) -> ItemKeys {
        let item = &self.item;
        let keys = self.look.over(of_input(&self.read, file));
        ItemKeys {
            kind: item.kind.map(|kind| kind.name().to_owned()),
            up: item.up,
            scale: item.scale,
            rotate: item.rotate.clone(),
            translate: item.translate,
            drape: item.drape.as_deref().map(text),
            posts: item.posts,
            opacity: keys.opacity.or(item.point_opacity.map(Opacity::Share)),
            color: item.point_color,
            radius: item.radius,
            ..keys
        }
    }
}

impl LookArgs {
    /// The keys of an item with this look.
    fn over(&self, item: ItemKeys) -> ItemKeys {
        ItemKeys {
            tf: self.tf.as_deref().map(text),
            cmap: self.cmap.clone(),
            clim: self.clim,
            opacity: self.opacity.clone().map(Opacity::Curve),
            iso: self.iso,
            unit_distance: self.unit_distance,
            labels: self.labels,
            ..item
        }
    }
}

/// The flags of reading as keys of an item.
pub(crate) fn of_input(read: &InputArgs, file: &str) -> ItemKeys {
    ItemKeys {
        dims: read.dims,
        sample_type: read.sample_type.map(|kind| kind.name().to_owned()),
        spacing: read.spacing,
        endian: read.endian.map(|endian| match endian {
            Endian::Little => "little".to_owned(),
            Endian::Big => "big".to_owned(),
        }),
        offset: read.offset,
        array: read.array.clone(),
        component: read.component,
        channel: read.channel,
        time: read.time,
        level: read.level,
        series: read.series.clone(),
        solution: read.solution.as_deref().map(text),
        ..ItemKeys::of_file(file)
    }
}

impl AnimateArgs {
    /// The flags as a document.
    pub(crate) fn document(&self, item_file: Option<&str>) -> Document {
        Document {
            animation: AnimationKeys {
                turntable: self.turntable,
                path: self.path.as_deref().map(text),
                keys: None,
                frames: self.frames,
                fps: self.fps,
                ease: self.ease.then_some(true),
                shutter: self.shutter,
            },
            ..self.render.document(item_file)
        }
    }
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

impl From<&CameraArgs> for CameraKeys {
    fn from(args: &CameraArgs) -> Self {
        Self {
            view: args.view,
            fit: args.fit,
            position: args.camera_pos,
            target: args.camera_target,
            up: args.camera_up,
            fov: args.camera_fov,
            orthographic: args
                .orthographic
                .map(|height| height.map_or(Parallel::Fits(true), Parallel::Height)),
            azimuth: args.azimuth,
            elevation: args.elevation,
            zoom: args.zoom,
        }
    }
}

impl MethodArgs {
    /// The keys of the method.
    pub(crate) fn keys(&self, gaussians: Option<GaussianModeName>) -> SettingKeys {
        let keys = SettingKeys {
            preset: self.preset,
            compositing: self.compositing,
            classification: self.classification,
            gaussians,
            sheet_thickness: self.sheet_thickness,
            gradient: self.gradient,
            level_bias: self.level_bias,
            filter: self.filter,
            pixel_sigma: self.pixel_sigma,
            coverage: self.coverage,
            coverage_samples: self.coverage_samples,
            coverage_contrast: self.coverage_contrast,
            termination: self.termination,
            prefilter: yes_or_no(self.prefilter, self.no_prefilter),
            shade: yes_or_no(self.shade, self.no_shade),
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            specular_power: self.specular_power,
            gradient_floor: self.gradient_floor,
            light: self.light,
            ..SettingKeys::default()
        };
        let parts = [
            (&self.kernel).into(),
            (&self.footprint).into(),
            (&self.fastsplats).into(),
        ];
        parts.into_iter().fold(keys, SettingKeys::or)
    }
}

fn yes_or_no(yes: bool, no: bool) -> Option<bool> {
    (yes || no).then_some(yes)
}

impl From<&KernelArgs> for SettingKeys {
    fn from(args: &KernelArgs) -> Self {
        Self {
            kernel: args.kernel,
            kernel_sigma: args.kernel_sigma,
            kernel_radius: args.kernel_radius,
            kernel_alpha: args.kernel_alpha,
            ..Self::default()
        }
    }
}

impl From<&FootprintArgs> for SettingKeys {
    fn from(args: &FootprintArgs) -> Self {
        Self {
            sheet: args.sheet,
            absorption: args.absorption,
            alignment: args.alignment,
            alignment_budget: args.alignment_budget,
            sheet_values: args.sheet_values,
            sheet_precision: args.sheet_precision,
            alignment_switch: args.alignment_switch,
            stretch: args.stretch,
            kernel_edge: args.kernel_edge,
            occlusion: args.occlusion,
            reconstruction: args.reconstruction,
            flatness: args.flatness,
            surface_gradient: args.surface_gradient,
            ..Self::default()
        }
    }
}

impl From<&FastSplatsArgs> for SettingKeys {
    fn from(args: &FastSplatsArgs) -> Self {
        Self {
            rasterizer: args.rasterizer,
            table_entries: args.table_entries,
            table_precision: args.table_precision,
            table_sections: args.table_sections,
            subpixels: args.subpixels,
            blit_radius: args.blit_radius,
            extract_density: args.extract_density,
            extract_gradient: args.extract_gradient,
            ..Self::default()
        }
    }
}

impl From<&EffectArgs> for EffectKeys {
    fn from(args: &EffectArgs) -> Self {
        let file = |path: &Option<PathBuf>| path.as_deref().map(text);
        Self {
            texture: args.texture,
            texture_scale: args.texture_scale,
            bump: file(&args.bump),
            bump_height: args.bump_height,
            environment: file(&args.environment),
            environment_share: args.environment_share,
            gradient_opacity: args.gradient_opacity.clone().map(|curve| curve.0),
            tf2d: file(&args.tf2d),
            // Flags name a file; scene files and pictures can hold the regions themselves.
            regions: None,
            iso_exact: args.iso_exact.then_some(true),
            clip_plane: Some(args.clip_plane.clone()).filter(|planes| !planes.is_empty()),
            clip_box: args.clip_box,
            clip_inside: yes_or_no(args.clip_inside, args.clip_outside),
        }
    }
}

impl From<&MotionArgs> for MotionKeys {
    fn from(args: &MotionArgs) -> Self {
        Self {
            spin: args.spin,
            spin_axis: args.spin_axis,
            spin_centre: args.spin_centre,
            velocity: args.velocity,
            motion_blur: args.motion_blur,
            subframes: args.subframes,
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests;
