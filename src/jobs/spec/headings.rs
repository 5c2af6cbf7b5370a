//! Headings of options in help.

/// Options about the scene and its file.
pub const SCENE: &str = "Scene";
/// Options about the camera.
pub const CAMERA: &str = "Camera";
/// Options that trade time for a better picture.
pub const QUALITY: &str = "Quality";
/// Options about the picture's file and the report.
pub const OUTPUT: &str = "Output";
/// Options for renders of many frames, hours or machines.
pub const LONG_RENDERS: &str = "Long renders";
/// Options about threads, memory and kernels.
pub const MACHINE: &str = "Machine";
