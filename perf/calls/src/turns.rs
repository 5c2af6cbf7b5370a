//! Casts that take turns, so that what slows the machine down slows all of them.

use std::time::Instant;

/// A cast by its name.
pub type NamedCast<'a> = (String, Box<dyn FnMut() -> usize + 'a>);

/// Seconds of each round of each cast. A round lets each cast all rays once.
pub fn take_turns(rounds: usize, casts: &mut [NamedCast]) -> Vec<Vec<f64>> {
    let mut seconds = vec![Vec::new(); casts.len()];
    for round in 0..=rounds {
        for ((_, cast), seconds) in casts.iter_mut().zip(&mut seconds) {
            let start = Instant::now();
            std::hint::black_box(cast());
            // The first round warms up.
            if round > 0 {
                seconds.push(start.elapsed().as_secs_f64());
            }
        }
    }
    seconds
}

pub fn median(mut all: Vec<f64>) -> f64 {
    all.sort_unstable_by(f64::total_cmp);
    all[all.len() / 2]
}
