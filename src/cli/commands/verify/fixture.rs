//! A film for tests.

use phalanx::render::{Film, Hits, NO_HIT};

/// Six pixels; the first has no hit.
pub fn film() -> Film {
    Film {
        width: 3,
        height: 2,
        planes: [vec![0.0; 6], vec![0.5; 6], vec![f32::NAN; 6]],
        aovs: Default::default(),
        aov_planes: Vec::new(),
        hits: Some(Hits {
            prim_id: vec![NO_HIT, 1, 2, 3, 4, 5],
            t: vec![1.0; 6],
            u: vec![0.25; 6],
            v: vec![0.5; 6],
        }),
    }
}
