//! Textures whose texels are not blended: KhronosGroup/glTF-Sample-Viewer#385.

use crate::textures::{film, square, texture};
use glam::Vec2;
use phalanx::sampling::linear_of_srgb;
use phalanx::scene::{Scene, Texture, Wrap};

fn nearest(wrap: Wrap, uvs: [Vec2; 4]) -> Scene {
    let texels = texture(2, 2, [wrap; 2], |x, y| [255 * x as u8, 255 * y as u8, 90]);
    let picture = Texture {
        nearest: true,
        ..texels
    };
    square([32, 32], picture, Some(uvs))
}

#[test]
fn texels_of_the_nearest_filter_are_squares_with_sharp_edges() {
    let blue = linear_of_srgb()[90];
    let corners = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
        let film = film(&nearest(wrap, corners.map(Vec2::from)));
        for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
            let edge = |k: u32| if k < 16 { 0.0 } else { 1.0 };
            assert_eq!(
                film.pixel(x, y),
                [edge(x), edge(y), blue],
                "{wrap:?} {x} {y}"
            );
        }
    }
}

#[test]
fn texels_of_the_nearest_filter_continue_beyond_the_edges() {
    // The columns of texels around u = -0.25, 0.25, 0.75 and so on, off their centres.
    for (wrap, columns) in [
        (Wrap::Repeat, [1.0, 0.0, 1.0, 0.0]),
        (Wrap::Clamp, [0.0, 0.0, 1.0, 1.0]),
        (Wrap::Mirror, [0.0, 0.0, 1.0, 1.0]),
    ] {
        for (k, column) in columns.into_iter().enumerate() {
            let u = k as f32 * 0.5 - 0.15;
            let film = film(&nearest(wrap, [Vec2::new(u, 0.25); 4]));
            assert_eq!(film.pixel(7, 7)[0], column, "{wrap:?} {u}");
        }
    }
}
