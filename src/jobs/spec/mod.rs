//! The description of a picture. Its fields are the options of the command line. Plans store it,
//! its JSON and the scene's fingerprint form the key of finished tiles, and it prints the command
//! in a picture's header.

mod as_text;
mod encoding_spec;
#[cfg(feature = "clap")]
#[doc(hidden)]
pub mod headings;
mod numbers;
mod option_row;
mod picture_spec;
mod pixel_spec;
mod scene_overrides;
mod scene_values;

pub use as_text::{AsText, Named, OptionValue};
pub use encoding_spec::{EncodingSpec, ExposureSpec, ToneSpec};
#[doc(hidden)]
pub use numbers::{parse_number, parse_size};
pub(crate) use option_row::OptionRow;
pub use picture_spec::{PictureSpec, set_header};
pub use pixel_spec::{AntiAliasing, IntegratorName, PixelSpec};
pub use scene_overrides::{SceneOverrides, Terminator, camera_options};
