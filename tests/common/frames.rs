//! Frames of both engines, and the first bit in which two differ.

use phalanx::frame::{Accel, Control, Frame, Settings, render};
use phalanx::scene::Scene;

/// A frame, rendered without interruption.
pub fn frame_of(scene: &Scene, prepared: &Accel, settings: Settings) -> Frame {
    render(scene, prepared, &settings, &Control::default()).expect("a frame")
}

/// The first pixel in which two frames differ by a bit, including hits.
pub fn difference(a: &Frame, b: &Frame) -> Option<String> {
    let (hits_a, hits_b) = (a.film.hits.as_ref()?, b.film.hits.as_ref()?);
    let floats = |f: &Frame, k: usize| -> Vec<u32> {
        let hits = f.film.hits.as_ref().expect("recorded hits");
        let all = [
            &f.film.planes[0],
            &f.film.planes[1],
            &f.film.planes[2],
            &hits.t,
            &hits.u,
            &hits.v,
        ];
        all[k].iter().map(|v| v.to_bits()).collect()
    };
    if let Some(i) = (0..hits_a.prim_id.len()).find(|&i| hits_a.prim_id[i] != hits_b.prim_id[i]) {
        let (a, b) = (hits_a.prim_id[i], hits_b.prim_id[i]);
        return Some(format!("pixel {i} hits {a} and {b}"));
    }
    for (k, name) in ["red", "green", "blue", "t", "u", "v"]
        .into_iter()
        .enumerate()
    {
        let (a, b) = (floats(a, k), floats(b, k));
        if let Some(i) = (0..a.len()).find(|&i| a[i] != b[i]) {
            let (a, b) = (f32::from_bits(a[i]), f32::from_bits(b[i]));
            return Some(format!("{name} of pixel {i}: {a:e} and {b:e}"));
        }
    }
    let (a, b) = (a.stats.rays, b.stats.rays);
    (a != b).then(|| format!("ray counts {a:?} and {b:?}"))
}
