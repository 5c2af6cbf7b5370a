//! Random scenes in the `.test` format, so that a failing one can be kept and rendered.
//!
//! Sizes range from 10⁻²⁰ to 10²⁰. A scene has a small part, where the camera is, and a large one,
//! up to 10¹⁰ times as large: rounding that is negligible for one is large for the other.

use crate::common::rng::Rng;
use std::fmt::Write;

/// Largest power of ten by which the large part of a scene exceeds the small one.
pub const MAX_RATIO_EXPONENT: f32 = 10.0;

/// Text of a scene under construction.
struct SceneText<'r> {
    rng: &'r mut Rng,
    text: String,
    /// Sizes of the small and of the large part.
    sizes: [f64; 2],
    /// Number of vertices of both kinds written so far.
    vertices: usize,
    normal_vertices: usize,
    /// Position of the small part.
    center: [f64; 3],
}

/// A scene and the ratio of its parts, as a power of ten.
pub fn random_scene(rng: &mut Rng) -> (String, f32) {
    let ratio = match rng.below(4) {
        0 => rng.range(0.0, 1.0),
        1 => rng.range(1.0, 6.0),
        _ => rng.range(5.0, MAX_RATIO_EXPONENT),
    };
    let exponent = match rng.below(3) {
        0 => 0.0,
        _ => rng.range(-20.0, 20.0 - ratio),
    };
    let small = 10f64.powf(f64::from(exponent));
    let sizes = [small, small * 10f64.powf(f64::from(ratio))];
    let mut scene = SceneText {
        rng,
        text: String::new(),
        sizes,
        vertices: 0,
        normal_vertices: 0,
        center: [0.0; 3],
    };
    scene.write_all();
    (scene.text, ratio)
}

impl SceneText<'_> {
    fn write_all(&mut self) {
        let size = self.rng.pick(&[[33, 25], [48, 36], [64, 40], [17, 70]]);
        self.line("size", &size.map(f64::from));
        let depth = self.rng.pick(&[0.0, 1.0, 2.0, 3.0, 5.0]);
        self.line("maxdepth", &[depth]);
        if self.rng.once_in(3) {
            let far = self.magnitude(0.0, 1.0) * self.some_size();
            self.center = self.point(far);
        }
        self.camera();
        self.lights();
        let groups = 1 + self.rng.below(3);
        for _ in 0..groups {
            self.material();
            self.group(0);
        }
        for _ in 0..1 + self.rng.below(2) {
            self.material();
            match self.rng.below(3) {
                0 => self.floor(),
                _ => self.group(1),
            }
        }
        if self.rng.once_in(3) {
            self.nested_glass();
        }
    }

    fn line(&mut self, command: &str, numbers: &[f64]) {
        self.text += command;
        for number in numbers {
            let _ = if number.fract() == 0.0 && number.abs() < 1e6 {
                write!(self.text, " {number}")
            } else {
                write!(self.text, " {number:e}")
            };
        }
        self.text.push('\n');
    }

    fn some_size(&mut self) -> f64 {
        let k = self.rng.below(2);
        self.sizes[k]
    }

    /// A power of ten, evenly in the exponent.
    fn magnitude(&mut self, low: f32, high: f32) -> f64 {
        10f64.powf(f64::from(self.rng.range(low, high)))
    }

    /// In the cube of half side `half` about the origin.
    fn point(&mut self, half: f64) -> [f64; 3] {
        let mut coordinate = || f64::from(self.rng.range(-1.0, 1.0)) * half;
        [coordinate(), coordinate(), coordinate()]
    }

    /// About the small part, within `far`.
    fn place(&mut self, far: f64) -> [f64; 3] {
        let offset = self.point(far);
        std::array::from_fn(|k| self.center[k] + offset[k])
    }

    fn camera(&mut self) {
        let far = match self.rng.below(6) {
            0 => self.sizes[1],
            1 => self.sizes[0] * 1e-3,
            2 => (self.sizes[0] * self.sizes[1]).sqrt(),
            _ => self.sizes[0] * 2.0,
        };
        let eye = match self.rng.below(6) {
            0 => [0.0; 3],
            _ => self.place(far),
        };
        let mut target = self.place(self.sizes[0]);
        if target == eye {
            target[1] += self.sizes[0];
        }
        let up = self.point(1.0);
        let fovy = f64::from(self.rng.pick(&[20.0f32, 45.0, 60.0, 90.0, 130.0]));
        let numbers = [eye, target, up].concat();
        self.line("camera", &[&numbers[..], &[fovy]].concat());
    }

    fn lights(&mut self) {
        if self.rng.once_in(4) {
            let quadratic = 1.0 / self.some_size().powi(2).clamp(1e-30, 1e30);
            self.line("attenuation", &[0.5, 0.0, quadratic]);
        }
        let color = [0.8, 0.7, 0.9];
        for _ in 0..1 + self.rng.below(5) {
            let far = match self.rng.below(5) {
                0 => self.sizes[1],
                1 => self.sizes[0] * 1e-3,
                2 => (self.sizes[0] * self.sizes[1]).sqrt(),
                _ => self.sizes[0] * 3.0,
            };
            let numbers = [self.place(far), color].concat();
            if self.rng.once_in(4) {
                let numbers = [self.point(1.0), color].concat();
                self.line("directional", &numbers);
            } else {
                self.line("point", &numbers)
            }
        }
    }

    fn material(&mut self) {
        let unit = |rng: &mut Rng| [0; 3].map(|_| f64::from(rng.unit()));
        let (diffuse, mirror, through) = (unit(self.rng), unit(self.rng), unit(self.rng));
        self.line("diffuse", &diffuse);
        let black = [0.0; 3];
        let mirrors = self.rng.once_in(2);
        self.line("specular", if mirrors { &mirror } else { &black });
        let clear = self.rng.once_in(4);
        self.line("transmission", if clear { &through } else { &black });
        let ior = self.rng.pick(&[1.0f32, 1.5, 0.7, 2.4]);
        self.line("ior", &[f64::from(ior)]);
        let shininess = self.rng.pick(&[1.0f32, 20.0, 1000.0]);
        self.line("shininess", &[f64::from(shininess)]);
    }

    /// Primitives of the small or of the large part, within a few transforms.
    fn group(&mut self, part: usize) {
        self.line("pushTransform", &[]);
        let size = self.sizes[part];
        let center = match part {
            0 => self.place(size),
            _ => self.point(size),
        };
        self.line("translate", &center);
        // Object space has its own size, made up for by the scale.
        let space = match self.rng.below(3) {
            0 => self.magnitude(-8.0, 8.0),
            _ => size,
        };
        let scale = size / space;
        for _ in 0..self.rng.below(3) {
            self.turn_and_stretch();
        }
        self.line("scale", &[scale; 3]);
        for _ in 0..1 + self.rng.below(4) {
            match self.rng.below(4) {
                0 => self.sphere(space),
                1 => self.smooth_triangle(space),
                _ => self.triangles(space),
            }
        }
        self.line("popTransform", &[]);
    }

    /// A rotation and a scale along the turned axes: two of them shear; a mirror now and then.
    fn turn_and_stretch(&mut self) {
        let axis = self.point(1.0);
        let angle = f64::from(self.rng.range(-180.0, 180.0));
        self.line("rotate", &[&axis[..], &[angle]].concat());
        if self.rng.once_in(2) {
            let mut stretch = [0; 3].map(|_| self.magnitude(-0.7, 0.7));
            if self.rng.once_in(3) {
                stretch[0] = -stretch[0];
            }
            self.line("scale", &stretch);
        }
    }

    fn sphere(&mut self, size: f64) {
        let center = self.point(size);
        let radius = size * self.magnitude(-2.0, 0.0);
        self.line("sphere", &[&center[..], &[radius]].concat());
    }

    fn vertex(&mut self, position: [f64; 3]) -> f64 {
        self.line("vertex", &position);
        self.vertices += 1;
        (self.vertices - 1) as f64
    }

    /// A few that share corners; some coincide, are flat along an axis, thin, or degenerate.
    fn triangles(&mut self, size: f64) {
        let flat = self.rng.once_in(3);
        let thin = if self.rng.once_in(4) { self.magnitude(-6.0, -1.0) } else { 1.0 };
        let first = self.vertices;
        let count = 3 + self.rng.below(6);
        for _ in 0..count {
            let mut position = self.point(size);
            position[1] *= thin;
            if flat {
                position[2] = 0.0;
            }
            if self.rng.once_in(12) {
                position = [0.0; 3];
            }
            self.vertex(position);
        }
        for _ in 0..count {
            let corners = [0; 3].map(|_| (first + self.rng.below(count)) as f64);
            for _ in 0..1 + usize::from(self.rng.once_in(8)) {
                self.line("tri", &corners);
            }
        }
    }

    fn smooth_triangle(&mut self, size: f64) {
        for _ in 0..3 {
            let numbers = [self.point(size), self.point(1.0)].concat();
            self.line("vertexnormal", &numbers);
            self.normal_vertices += 1;
        }
        let last = self.normal_vertices as f64;
        self.line("trinormal", &[last - 3.0, last - 2.0, last - 1.0]);
    }

    /// A square as large as the large part, along axes or a little turned, a little below the small
    /// one.
    fn floor(&mut self) {
        let half = self.sizes[1];
        let below = self.center[1] - self.sizes[0] * f64::from(self.rng.range(0.0, 2.0));
        self.line("pushTransform", &[]);
        self.line("translate", &[self.center[0], below, self.center[2]]);
        if self.rng.once_in(2) {
            let angle = f64::from(self.rng.range(-2.0, 2.0));
            self.line("rotate", &[1.0, 0.0, 0.3, angle]);
        }
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let first = self.vertices as f64;
        for [x, z] in corners {
            self.vertex([x * half, 0.0, z * half]);
        }
        self.line("tri", &[first, first + 2.0, first + 1.0]);
        self.line("tri", &[first, first + 3.0, first + 2.0]);
        self.line("popTransform", &[]);
    }

    fn nested_glass(&mut self) {
        self.line("diffuse", &[0.0; 3]);
        self.line("specular", &[0.2; 3]);
        self.line("transmission", &[0.9, 0.8, 0.7]);
        self.line("ior", &[1.5]);
        let center = self.place(self.sizes[0]);
        for share in [0.5, 0.3, 0.1] {
            let radius = share * self.sizes[0];
            self.line("sphere", &[&center[..], &[radius]].concat());
        }
    }
}
