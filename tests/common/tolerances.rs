//! All tolerances of the integration tests, each with its reason. Everything else is compared bit
//! for bit.

/// A component of a camera direction against f64: some ten roundings of numbers of size 1.
pub const DIRECTION: f64 = 10.0 * EPSILON;

/// A camera direction's length against 1: the dot product, root, quotient and three products.
pub const UNIT_LENGTH: f64 = 4.0 * EPSILON;

/// An orthonormal frame's products against 0 and 1: three components rounded to f32 each.
pub const FRAME: f64 = 3.0 * EPSILON;

/// A radiance against its closed form, relative: some thirty roundings from the camera ray to the
/// sum.
pub const RADIANCE: f64 = 64.0 * EPSILON;

/// As [`RADIANCE`], if a distance, its square and an angle against a wall carry the hit point's
/// error as well.
pub const ATTENUATED: f64 = 4.0 * RADIANCE;

/// As [`RADIANCE`] and [`SPECULAR_PER_SHININESS`] on a sphere seen from a few radii away: the
/// distance's rounding turns the normal by the same amount.
pub const ON_A_SPHERE: f64 = 8.0;

/// Diffuse light on an ellipsoid with axes of 2 to 0.5: where its curvature is 8, the hit point's
/// error turns the normal by eight times that amount, and the cosine may be as small as 0.05.
pub const ON_AN_ELLIPSOID: f64 = 20.0 * RADIANCE;

/// A distance of about 4 to that ellipsoid, possibly at a grazing angle: some hundred roundings of
/// 4.
pub const ELLIPSOID_DISTANCE: f64 = 1e-5;

/// A distance to a sphere, per distance of its centre: the roundings of the ray's closest point to
/// the centre, of a root whose slope is 0.6 there, and of the distance itself. At most a seventh of
/// the radius in the test.
pub const FAR_SPHERE: f64 = 8.0 * EPSILON;

/// An angle by an environment's map, in addition to the square of a texel's angle, which bounds the
/// distance of a chord from its arc: roundings of the direction, of its angles and of colours.
pub const ENVIRONMENT_ANGLE: f64 = 30.0 * EPSILON;

/// A point on a plane at distance one, from a camera direction; a distance of about 1.
pub const PLACE: f32 = 1e-6;

/// A pixel of 1,024 samples across an edge along a column, against the filter's integral: the
/// samples stand in 1,024 columns of equal parts of the filter, one in each, so the edge parts one
/// of them; twice that for what weights differ within a part.
pub const SAMPLED_EDGE: f64 = 2.0 / 1024.0;

/// As [`SAMPLED_EDGE`] for Mitchell's filter, whose weights jump from 1.1 to -1.1 twice along each
/// axis: there, too, a part of 1/1024 may be on the wrong side.
pub const SAMPLED_LOBES: f64 = SAMPLED_EDGE + 4.0 * 2.2 / 1024.0;

/// Distance (root of the mean square) of pictures whose pixels are means of the same samples, added
/// in another order in f64 and rounded to f32: values are below 2.
pub const ALL_SAMPLES: f64 = 1.2e-7;

/// A mean over a light of 1,024 samples, one in each of as many equal parts, where an edge hides
/// some of it: on a curved map the edge passes through some 64 parts, and each is off by half at
/// most, to either side.
pub const HIDDEN_SHARE: f64 = 0.25 * 64.0 / 1024.0;

/// A mean of 4,096 samples, one in each of as many equal parts, of something that changes by a
/// factor of about ten over all of them and is nowhere steep: relative.
pub const SMOOTH_MEAN: f64 = 1e-3;

/// As [`HIDDEN_SHARE`], of 4,096 samples: the edge, a circle, passes through some 200 parts at
/// most.
pub const SAMPLED_CAP: f64 = 0.25 * 200.0 / 4096.0;

/// The variance of a blurred picture, relative, of some 10,000 rays that meet what is blurred: 1.4
/// % if they had nothing to do with each other, and they are spread evenly.
pub const BLUR_WIDTH: f64 = 0.03;

/// A specular term against its closed form, relative, per unit of shininess: x^s turns a relative
/// error e of x into s·e, and x carries those of two normalised vectors.
pub const SPECULAR_PER_SHININESS: f64 = 16.0 * EPSILON;

/// Half a unit in the last place of 1 in f32: the relative error of one operation.
pub const EPSILON: f64 = 1.0 / 16_777_216.0;

/// A hit place against f64, in units of [`EPSILON`] times the lengths involved (origin and farthest
/// corner, or origin, centre and radius), which are summed and so count up to twice: some ten
/// roundings stand between the input and an edge function or a root, and their errors are not all
/// at their largest together.
pub const HIT_ULPS: f64 = 8.0;

/// As [`HIT_ULPS`] for a cone, with the lengths counted once: the ray's way to the cone's box is
/// the only long one, and rounds once.
pub const CONE_ULPS: f64 = 2.0;

/// A distance or a place on a cone of about that size: a hundred roundings.
pub const ON_A_CONE: f64 = 100.0 * EPSILON;

/// Barycentric weights of a well-shaped triangle against f64.
pub const BARYCENTRIC: f64 = 32.0 * EPSILON;

/// Share of reference pixels that must agree: the share on which independent renderings agree with
/// each other.
pub const REFERENCE_SHARE: f64 = 0.995;

/// Share of pixels with equal coverage in a rendering whose colours are not comparable.
pub const COVERAGE_SHARE: f64 = 0.999;

/// Levels of 255 by which a pixel may differ from the median of the references: floor(255 c) on
/// either side of an integer.
pub const REFERENCE_LEVELS: i32 = 1;

/// Spread, in levels, beyond which a reference pixel is ignored.
pub const REFERENCE_SPREAD: u8 = 2;

/// The sum of light by three paths, against the radiance: each path is a separate mean, rounded to
/// f32 once, as is the radiance of every sample.
pub const LAYER_SUM: f32 = 4.0 * f32::EPSILON;

/// A distance to any triangle, relative: the requirement, three times the worst of ten million
/// rays.
pub const DISTANCE: f64 = 1e-5;

/// Share of hits on curved primitives that f64 cannot decide with the bounds of [`HIT_ULPS`] and
/// [`CONE_ULPS`]: at silhouettes, at the ends of cones, and where a ray or its limit begins on a
/// surface, as a quarter of the rays in that test do.
pub const UNDECIDED_CROSSINGS: f64 = 0.05;
