//! The description of a picture. Its fields are the options of the command line. Plans store it,
//! its JSON and the scene's fingerprint form the key of finished tiles, and it prints the command
//! in a picture's header.

mod encoding_spec;
#[cfg(feature = "clap")]
#[doc(hidden)]
pub mod headings;
mod numbers;
mod options;
mod picture_spec;
mod pixel_spec;
mod scene_overrides;

pub use encoding_spec::{EncodingSpec, ToneSpec};
#[doc(hidden)]
pub use numbers::{parse_number, parse_size};
pub(crate) use options::{fields, option_name, option_text, texts};
pub use picture_spec::{PictureSpec, set_header};
pub use pixel_spec::PixelSpec;
pub use scene_overrides::SceneOverrides;
