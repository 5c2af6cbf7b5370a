//! The matrix stack, in f64: values for the scene are rounded to f32 once.

use crate::diagnostics::Span;
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Bound on the difference of MᵀM from s²·I, relative to s², for M to count as a similarity. It is
/// far above the rounding errors of a stack of rotations (about 1e-16 each), and far below anything
/// that an f32 operand can express.
const SIMILARITY: f64 = 1e-12;

/// Condition number (Frobenius) beyond which a matrix counts as singular: with it, the rounding
/// error of an f32 coordinate in world space is as large as the whole object in object space.
const WORST_CONDITION: f64 = 16_777_216.0; // 2^24

/// Maximum number of transforms that may be saved at a time. Each takes eight times the memory of
/// its statement, and real scenes have tens.
pub(super) const MOST_SAVED: usize = 1 << 16;

/// The current transform, and the saved ones.
pub(super) struct Transforms {
    current: DAffine3,
    saved: Vec<(DAffine3, Span)>,
    /// Pushes beyond [`MOST_SAVED`] that have not been popped.
    beyond: usize,
}

impl Transforms {
    pub(super) fn new() -> Self {
        Transforms {
            current: DAffine3::IDENTITY,
            saved: Vec::new(),
            beyond: 0,
        }
    }

    pub(super) fn current(&self) -> DAffine3 {
        self.current
    }

    /// Right-multiplies, as OpenGL does: the last declared transform acts first. Returns false, and
    /// changes nothing, if the product is not finite.
    pub(super) fn apply(&mut self, step: DAffine3) -> bool {
        let product = self.current * step;
        let fits = product.is_finite();
        if fits {
            self.current = product;
        }
        fits
    }

    /// Saves the current transform. Returns false if that would be one more than [`MOST_SAVED`].
    /// Pushes beyond the limit are only counted, so that each pop matches its own push.
    pub(super) fn push(&mut self, span: Span) -> bool {
        if self.saved.len() < MOST_SAVED {
            self.saved.push((self.current, span));
            return true;
        }
        self.beyond += 1;
        self.beyond > 1
    }

    /// Restores the last saved transform; false if there is none.
    pub(super) fn pop(&mut self) -> bool {
        if self.beyond > 0 {
            self.beyond -= 1;
            return true;
        }
        match self.saved.pop() {
            Some((saved, _)) => {
                self.current = saved;
                true
            }
            None => false,
        }
    }

    /// Span of the outermost push that has not been popped, and the number of such pushes.
    pub(super) fn unclosed(&self) -> Option<(Span, usize)> {
        let &(_, outermost) = self.saved.first()?;
        Some((outermost, self.saved.len()))
    }
}

/// Counter-clockwise rotation about an axis of any length but zero, by Rodrigues' formula:
/// R = cos·I + (1 − cos)·a·aᵀ + sin·\[a\]ₓ.
pub(super) fn rotation(axis: DVec3, degrees: f64) -> Option<DAffine3> {
    let a = axis.try_normalize()?;
    let (sin, cos) = sin_cos(degrees);
    let column = |e: DVec3| e * cos + a * ((1.0 - cos) * a.dot(e)) + a.cross(e) * sin;
    Some(DAffine3::from_cols(
        column(DVec3::X),
        column(DVec3::Y),
        column(DVec3::Z),
        DVec3::ZERO,
    ))
}

/// Sine and cosine by libm, whose bits, unlike those of the system's functions, are the same
/// everywhere. Whole quarter turns are subtracted first (exactly: both remainders are), so that 90
/// degrees turn x into exactly y.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let degrees = degrees % 360.0;
    let quarters = (degrees / 90.0).round();
    let rest = (degrees - 90.0 * quarters).to_radians();
    let (sin, cos) = (libm::sin(rest), libm::cos(rest));
    match (quarters as i32).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The factor s by which a matrix scales all lengths, if it scales all alike: MᵀM = s²·I.
/// Reflections qualify.
pub(super) fn similarity(m: DMat3) -> Option<f64> {
    let gram = m.transpose() * m;
    let square = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
    let off = gram - DMat3::from_diagonal(DVec3::splat(square));
    let largest = off.to_cols_array().iter().fold(0.0, |m, x| x.abs().max(m));
    // The comparison also refuses values that overflowed on the way.
    (largest <= SIMILARITY * square && square.is_normal()).then(|| square.sqrt())
}

/// The inverse, unless the matrix flattens space so far that f32 could not undo it.
pub(super) fn inverse(m: DMat3) -> Option<DMat3> {
    let size = largest(m);
    // Scaled to about 1 first: the determinant of a matrix in units of 1e-150 would vanish although
    // its shape is fine.
    let unit = m * (1.0 / size);
    let inverse = unit.inverse();
    let condition = frobenius(unit) * frobenius(inverse);
    let inverse = inverse * (1.0 / size);
    (condition <= WORST_CONDITION && inverse.is_finite()).then_some(inverse)
}

fn largest(m: DMat3) -> f64 {
    m.to_cols_array().iter().fold(0.0, |m, x| x.abs().max(m))
}

fn frobenius(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The vector rounded to f32, unless that overflows.
pub(super) fn rounded(v: DVec3) -> Option<Vec3> {
    let v = v.as_vec3();
    v.is_finite().then_some(v)
}
