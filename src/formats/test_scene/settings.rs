//! Statements that a file has once: the image, the camera, the depth, the output's name.

use super::commands::Statement;
use super::reader::TestReader;
use glam::DVec3;
use phalanx_scene::{MAX_DEPTH_LIMIT, View, check_image_size};

impl TestReader<'_> {
    pub(super) fn size(&mut self, statement: &Statement<'_>) {
        if self.seen.size {
            self.report
                .error(statement.span(), "`size` stands here a second time");
        } else if self.seen.any {
            self.report.error(
                statement.span(),
                "`size` must be the first command of the file",
            );
        }
        self.seen.size = true;
        let Some([width, height]) = self.counts(statement) else {
            return;
        };
        match check_image_size(width, height) {
            // The check accepts only sides that fit.
            Ok(()) => (self.scene.width, self.scene.height) = (width as u32, height as u32),
            Err(error) => self.refuse(statement, 0, error.to_string()),
        }
    }

    pub(super) fn camera(&mut self, statement: &Statement<'_>) {
        if self.seen.camera {
            self.report.warning(
                statement.span(),
                "a second `camera`: the last one takes the picture",
            );
        }
        self.seen.camera = true;
        let Some([ex, ey, ez, cx, cy, cz, ux, uy, uz, fovy]) = self.coordinates(statement) else {
            return;
        };
        self.scene.view = View {
            eye: (DVec3::new(ex, ey, ez) - self.origin).as_vec3(),
            center: (DVec3::new(cx, cy, cz) - self.origin).as_vec3(),
            up: DVec3::new(ux, uy, uz).as_vec3(),
            fovy: fovy as f32,
            // `ortho` may stand before the camera.
            ortho: self.scene.view.ortho,
        };
        if let Err(error) = self.scene.view.basis() {
            self.report.error(statement.span(), error.to_string());
        }
    }

    /// Makes the camera's rays parallel; the operand is the visible height.
    pub(super) fn ortho(&mut self, statement: &Statement<'_>) {
        let Some([height]) = self.numbers(statement) else {
            return;
        };
        if height > 0.0 {
            self.scene.view.ortho = Some(height)
        } else {
            let message = "the visible height of parallel rays must be positive";
            self.refuse(statement, 0, message);
        }
    }

    pub(super) fn maxdepth(&mut self, statement: &Statement<'_>) {
        let Some([depth]) = self.counts(statement) else {
            return;
        };
        if depth <= u64::from(MAX_DEPTH_LIMIT) {
            self.scene.max_depth = depth as u32;
        } else {
            let message = format!("maxdepth {depth} is out of range: at most {MAX_DEPTH_LIMIT}");
            self.refuse(statement, 0, message);
        }
    }

    /// Sets the name of the output. A file name may hold spaces, so the operand is the rest of the
    /// line. Whether it is a bare name matters only to code that writes there.
    pub(super) fn output(&mut self, statement: &Statement<'_>) {
        let Some(name) = statement.joined() else {
            return self.missing_operands(statement, 0, 1);
        };
        self.scene.output = Some(name.text.to_owned());
    }

    pub(super) fn maxverts(&mut self, statement: &Statement<'_>) {
        if let Some([count]) = self.counts(statement) {
            self.vertices.promised = Some(count);
        }
    }

    pub(super) fn maxvertnorms(&mut self, statement: &Statement<'_>) {
        if let Some([count]) = self.counts(statement) {
            self.normal_vertices.promised = Some(count);
        }
    }
}

/// Returns true if a scene's name for its output stays in the folder that it is joined to, on every
/// system: it has no folders, drives or control characters.
pub fn is_bare_name(name: &str) -> bool {
    let drive = name.as_bytes().get(1) == Some(&b':');
    let steers = |c: char| c == '/' || c == '\\' || c.is_control();
    !name.trim().is_empty() && name != "." && name != ".." && !drive && !name.contains(steers)
}
