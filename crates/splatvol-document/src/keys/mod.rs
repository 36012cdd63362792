//! Keys of the document: one struct per table. All keys are optional; an absent one is chosen when the document is
//! resolved.

mod animation;
mod camera;
mod domains;
mod effects;
mod item;
mod motion;
pub mod names;
mod place;
mod settings;
mod values;

pub use animation::{AnimationKeys, CameraFrame};
pub use camera::{CameraKeys, Parallel};
pub use domains::check_gradient_opacity;
pub(crate) use domains::check_regions;
pub use effects::EffectKeys;
pub use item::{ItemKeys, Opacity};
pub use motion::{CameraSweep, MotionKeys};
pub use place::{Axis, Rotate, Scale};
pub use settings::SettingKeys;
pub use values::{Background, CHARCOAL, PictureSize};

/// Defines a table of optional keys, with a union in which the first wins.
macro_rules! keys {
    ($(#[$about:meta])* pub struct $name:ident {
        $($(#[$key_about:meta])* $key:ident: $value:ty,)*
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
        pub struct $name {
            $(
                $(#[$key_about])*
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $key: Option<$value>,
            )*
        }

        impl $name {
            /// These keys; where one is absent, that of `other`.
            #[must_use]
            pub fn or(self, other: Self) -> Self {
                Self {
                    $($key: self.$key.or(other.$key),)*
                }
            }

            /// Whether no key is set.
            pub fn is_empty(&self) -> bool {
                true $(&& self.$key.is_none())*
            }
        }
    };
}
use keys;
