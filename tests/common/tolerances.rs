//! Every tolerance of the integration tests, each with its reason. What is not here is compared bit for bit.

/// A component of a camera direction against f64: some ten roundings of numbers of size 1.
pub const DIRECTION: f64 = 10.0 * EPSILON;

/// A camera direction's length against 1: the dot product, root, quotient and three products.
pub const UNIT_LENGTH: f64 = 4.0 * EPSILON;

/// An orthonormal frame's products against 0 and 1: three components rounded to f32 each.
pub const FRAME: f64 = 3.0 * EPSILON;

/// A radiance against its closed form, relative: some thirty roundings from the camera ray to the sum.
pub const RADIANCE: f64 = 64.0 * EPSILON;

/// A specular term against its closed form, relative, per unit of shininess: x^s turns a relative error e of x into
/// s·e, and x carries those of two normalised vectors.
pub const SPECULAR_PER_SHININESS: f64 = 16.0 * EPSILON;

/// Half a unit in the last place of 1 in f32, the relative error of one operation.
pub const EPSILON: f64 = 1.0 / 16_777_216.0;

/// A hit place against f64, in units of [`EPSILON`] times the lengths involved (origin and farthest corner, or origin,
/// centre and radius), which are summed and so count up to twice: some ten roundings stand between the input and an
/// edge function or a root, and their errors are not all at their largest together.
pub const HIT_ULPS: f64 = 8.0;

/// Barycentric weights of a well-shaped triangle against f64.
pub const BARYCENTRIC: f64 = 32.0 * EPSILON;

/// Share of reference pixels that must agree: what independent renderings agree on among themselves
/// (`../shared/formats.md`).
pub const REFERENCE_SHARE: f64 = 0.995;

/// Share of pixels whose coverage must agree with a rendering whose colours are not comparable.
pub const COVERAGE_SHARE: f64 = 0.999;

/// Levels of 255 by which a pixel may differ from the median of the references: floor(255 c) on either side of an
/// integer.
pub const REFERENCE_LEVELS: i32 = 1;

/// Reference pixels whose renderings spread by more levels than this say nothing.
pub const REFERENCE_SPREAD: u8 = 2;
