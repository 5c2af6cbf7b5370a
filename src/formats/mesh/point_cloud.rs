//! Point clouds: vertices of a file without faces, drawn as spheres.
//!
//! Colours become materials of a palette: fifteen bits, five for the square root of each linear
//! channel, which is close to how screens encode it. A material takes thirty times the memory of
//! a sphere's material number.

use super::polygon_mesh::MergedMesh;
use crate::memory::MemoryLedger;
use crate::options::ReadOptions;
use crate::origin::{self, ReadStop};
use crate::text::workers;
use glam::{DVec3, Vec3};
use phalanx_scene::{Material, NO_INDEX, Scene, Vec3s};

/// Bytes of a sphere, whose columns grow by doubling.
const SPHERE_BYTES: u64 = 2 * 24;
/// Highest number of a colour's channel.
const LEVELS: f32 = 31.0;
/// Number of colours, and bytes of a material for each.
const COLORS: usize = 1 << 15;
const MATERIAL_BYTES: u64 = 256;
/// Default radius, in median distances between nearest neighbours. From this radius on, most
/// surfaces look closed, for scans and for random points.
const SHARE: f64 = 1.5;
/// Number of points whose nearest neighbour is found.
const SAMPLES: usize = 64;
/// Number of distances that are compared side by side.
const LANES: usize = 8;

/// The default radius of points. `None` if they coincide.
fn radius(points: &Vec3s, threads: usize) -> Option<f32> {
    let samples = points.len().min(SAMPLES);
    let rows = (0..samples).map(|k| k * points.len() / samples).collect();
    let mut nearest = workers::map(threads, rows, |row| nearest(points, row));
    nearest.sort_by(f64::total_cmp);
    let radius = (SHARE * nearest.get(samples / 2)?.sqrt()) as f32;
    (radius > 0.0 && radius.is_finite()).then_some(radius)
}

/// The square of the distance to the nearest point at another position.
fn nearest(points: &Vec3s, row: usize) -> f64 {
    let own = points.get(row).as_dvec3();
    let [x, y, z] = points.parts().map(|part| part.chunks(LANES));
    let mut least = [f64::INFINITY; LANES];
    for ((x, y), z) in x.zip(y).zip(z) {
        for (lane, ((&x, &y), &z)) in least.iter_mut().zip(x.iter().zip(y).zip(z)) {
            let square = (DVec3::new(x.into(), y.into(), z.into()) - own).length_squared();
            if square > 0.0 && square < *lane {
                *lane = square;
            }
        }
    }
    least.into_iter().fold(f64::INFINITY, f64::min)
}

/// Leaves out vertices that cannot be used, with their colours.
fn drop_lost(mesh: &mut MergedMesh) {
    let lost = std::mem::take(&mut mesh.lost);
    for columns in [&mut mesh.vertices, &mut mesh.colors.rgb] {
        for column in columns.parts_mut() {
            let rows = (0..).zip(column.iter());
            let usable = rows.filter(|(row, _)| lost.binary_search(row).is_err());
            *column = usable
                .map(|(_, &number)| number)
                .collect::<Vec<f32>>()
                .into();
        }
    }
}

/// Adds a sphere for each vertex of a mesh without faces, in its colour over the material of row 0.
/// Returns the radius, unless there is none.
pub(super) fn add(
    scene: &mut Scene,
    mut mesh: MergedMesh,
    options: &ReadOptions,
    memory: &MemoryLedger,
) -> Result<Option<f32>, ReadStop> {
    if !mesh.lost.is_empty() {
        drop_lost(&mut mesh);
    }
    if let Some(origin) = options.origin.offset() {
        let rows: Vec<_> = (0..mesh.vertices.len() as u32)
            .map(|row| [row; 3])
            .collect();
        origin::move_exactly(&mut mesh.vertices, &rows, mesh.single, origin)?;
    }
    let threads = workers::thread_count(options.threads);
    let spaced = || radius(&mesh.vertices, threads);
    let Some(radius) = options.point_radius.or_else(spaced) else {
        return Ok(None);
    };
    let (points, colors) = (&mesh.vertices, &mesh.colors.rgb);
    let palette = points.len().min(COLORS) as u64 * MATERIAL_BYTES;
    memory.take(
        points.len() as u64 * SPHERE_BYTES + palette,
        "for the file's points",
    )?;
    let base = scene.materials.get(0);
    let mut rows = vec![NO_INDEX; COLORS];
    for k in 0..points.len() {
        let material = if colors.is_empty() {
            0
        } else {
            let levels =
                (colors.get(k).to_array()).map(|c| (c.sqrt().min(1.0) * LEVELS + 0.5).floor());
            let [r, g, b] = levels.map(|level| level as usize);
            let row = &mut rows[(r * 32 + g) * 32 + b];
            if *row == NO_INDEX {
                let color = Vec3::from(levels.map(|level| (level / LEVELS) * (level / LEVELS)));
                *row = scene.materials.push(&Material {
                    ka: base.ka * color,
                    kd: base.kd * color,
                    ..base
                });
            }
            *row
        };
        scene.add_sphere(points.get(k), radius, material);
    }
    Ok(Some(radius))
}
