//! Lights, and their attenuation.

use super::commands::Statement;
use super::reader::TestReader;
use super::transform::{rounded, similarity};
use glam::{DVec3, Vec3};

impl TestReader<'_> {
    pub(super) fn attenuation(&mut self, statement: &Statement<'_>) {
        let Some(factors) = self.numbers::<3>(statement) else {
            return;
        };
        if let Some(negative) = factors.iter().position(|&factor| factor < 0.0) {
            self.refuse(statement, negative, "an attenuation must not be negative");
        } else if factors == [0.0; 3] {
            self.report.error_with_help(
                statement.operand_place(0),
                "an attenuation of zero makes light without bound",
                "use `attenuation 1 0 0` for light that does not fade",
            );
        } else {
            self.attenuation = Vec3::from_array(factors);
        }
    }

    pub(super) fn point(&mut self, statement: &Statement<'_>) {
        let Some([x, y, z, r, g, b]) = self.coordinates(statement) else {
            return;
        };
        let position = self.to_scene(DVec3::new(x, y, z));
        if let Some(position) = self.in_range(statement, position) {
            let lights = &mut self.scene.lights;
            let color = DVec3::new(r, g, b).as_vec3();
            lights.add_point(position, color, self.attenuation);
        }
    }

    pub(super) fn directional(&mut self, statement: &Statement<'_>) {
        let Some([x, y, z, r, g, b]) = self.numbers(statement) else {
            return;
        };
        let toward = Vec3::new(x, y, z).as_dvec3();
        if toward == DVec3::ZERO {
            let message = "the vector toward a directional light must not be zero";
            return self.refuse(statement, 0, message);
        }
        let toward = self.transforms.current().transform_vector3(toward);
        match toward.try_normalize() {
            Some(toward) => {
                let lights = &mut self.scene.lights;
                lights.add_directional(toward.as_vec3(), Vec3::new(r, g, b));
            }
            None => self.out_of_range(statement),
        }
    }

    /// Adds a sphere light. It stays a sphere: transforms do not stretch a light.
    pub(super) fn spherelight(&mut self, statement: &Statement<'_>) {
        let Some([x, y, z, radius, r, g, b]) = self.coordinates(statement) else {
            return;
        };
        if radius <= 0.0 {
            return self.report.error_with_help(
                statement.operand_place(3),
                "the radius of a light must be positive",
                "a light without extent is a `point`",
            );
        }
        let transform = self.transforms.current();
        let Some(factor) = similarity(transform.matrix3) else {
            return self.report.error_with_help(
                statement.span(),
                "the current transform would make an ellipsoid of this light, and only spheres can shine",
                "scale x, y and z alike, or declare the light outside of the `scale`",
            );
        };
        let center = self.to_scene(DVec3::new(x, y, z));
        let radius = (radius * factor) as f32;
        match rounded(center).filter(|_| radius.is_finite() && radius > 0.0) {
            Some(center) => {
                let lights = &mut self.scene.lights;
                let color = DVec3::new(r, g, b).as_vec3();
                lights.add_sphere(center, radius, color, self.attenuation);
            }
            None => self.out_of_range(statement),
        }
    }

    /// Adds a rectangle light. It is a parallelogram under transforms that shear it, or if its
    /// edges are not perpendicular to each other.
    pub(super) fn rectlight(&mut self, statement: &Statement<'_>) {
        let Some([cx, cy, cz, ex, ey, ez, fx, fy, fz, r, g, b]) = self.coordinates(statement)
        else {
            return;
        };
        let [corner, e, f] = [[cx, cy, cz], [ex, ey, ez], [fx, fy, fz]].map(DVec3::from_array);
        let directions = [e, f].map(DVec3::normalize_or_zero);
        if directions[0].cross(directions[1]) == DVec3::ZERO {
            return self.report.error_with_help(
                statement.operand_place(3),
                "the edges of this light enclose no area",
                "give two edges that lead from the corner in different directions",
            );
        }
        let transform = self.transforms.current();
        let corner = rounded(self.to_scene(corner));
        let [e, f] = [e, f].map(|edge| rounded(transform.transform_vector3(edge)));
        let edge = |edge: Option<Vec3>| edge.filter(|&edge| edge != Vec3::ZERO);
        match (corner, edge(e), edge(f)) {
            (Some(corner), Some(e), Some(f)) => {
                let lights = &mut self.scene.lights;
                let color = DVec3::new(r, g, b).as_vec3();
                lights.add_rectangle(corner, [e, f], color, self.attenuation);
            }
            _ => self.out_of_range(statement),
        }
    }
}
