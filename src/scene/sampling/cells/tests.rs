use super::*;

const WHOLE: (u32, u32) = (8, 8);

/// Cells with all samples of a block of the picture `radiance`, a function of column and row in
/// pixels.
fn sampled(
    (spp, threshold): (u32, f32),
    size: (u32, u32),
    radiance: impl Fn([f64; 2]) -> f32,
) -> Cells {
    let mut cells = Cells::default();
    cells.begin(Adaptive { threshold }, spp, ((16, 40), size), false);
    loop {
        for ask in 0..cells.requests().len() {
            let sample = cells.samples.len() - cells.requests().len() + ask;
            let position = [0, 1].map(|axis| cells.samples[sample].across_block(axis));
            let value = radiance(position.map(|c| f64::from(c) / f64::from(PIXEL_SIDE)));
            let result = SampleResult {
                radiance: [value; 3],
                weight: 1.0,
                ..SampleResult::default()
            };
            cells.add_result(ask, &result);
        }
        if !cells.next_round() {
            return cells;
        }
    }
}

/// An edge that crosses the block at a slant.
fn slanted([x, y]: [f64; 2]) -> f32 {
    f32::from(u8::from(y > 0.3 * x + 2.21))
}

/// The part of a pixel below that edge. The edge crosses no corner of its left and right sides.
fn below([x, y]: [f64; 2]) -> f64 {
    // The mean over columns of the covered height of the pixel: exact for lines, except for the
    // corner that the edge cuts.
    let steps = 4096;
    let part = |k: i32| {
        let x = x + (f64::from(k) + 0.5) / f64::from(steps);
        (y + 1.0 - (0.3 * x + 2.21)).clamp(0.0, 1.0)
    };
    (0..steps).map(part).sum::<f64>() / f64::from(steps)
}

#[test]
fn what_is_plain_has_the_first_samples() {
    for size in [WHOLE, (3, 5)] {
        let cells = sampled((256, 1e-6), size, |_| 0.5);
        assert_eq!(cells.samples.len() as u32, size.0 * size.1 * FIRST_SAMPLES);
        for (k, sum) in (0..).zip(&cells.sums()) {
            let inside = k % BLOCK < size.0 && k / BLOCK < size.1;
            assert_eq!(sum.samples, if inside { FIRST_SAMPLES } else { 0 });
            if inside {
                assert_eq!(sum.radiance.mean(), [0.5; 3]);
            }
        }
    }
}

#[test]
fn each_sample_has_the_cell_that_it_lies_in_and_cells_cover_pixels() {
    let cells = sampled((4096, 1e-4), (8, 7), slanted);
    let mut area = [0.0; 64];
    for (k, sample) in cells.samples.iter().enumerate() {
        let pixel = &cells.pixels[usize::from(sample.pixel)];
        assert_eq!(pixel.sample_at(sample.position), k as u32);
        let corner = [0, 1].map(|axis| sample.from(axis));
        let last = [0, 1].map(|axis| corner[axis] + (sample.side(axis) - 1));
        assert_eq!(
            [pixel.sample_at(corner), pixel.sample_at(last)],
            [k as u32; 2]
        );
        area[usize::from(sample.pixel)] += 1.0 / f64::from(1 << sample.level);
    }
    assert!(area[..56].iter().all(|&area| area == 1.0), "{area:?}");
    assert!(cells.samples.iter().any(|sample| sample.level == 12));
}

/// An edge costs as many samples as it has cells, and they halve its error with every halving: far
/// less than the error of as many samples of a whole pixel.
#[test]
fn an_edge_gets_the_samples_and_they_pay() {
    let cells = sampled((4096, 2e-4), WHOLE, slanted);
    let (mut squares, mut crossed, mut samples) = (0.0, 0u32, 0);
    for (k, sum) in (0..).zip(&cells.sums()) {
        let corner = [f64::from(k % BLOCK), f64::from(k / BLOCK)];
        let want = below(corner);
        let got = f64::from(sum.radiance.mean()[0]);
        if want > 0.0 && want < 1.0 {
            (crossed, samples) = (crossed + 1, samples + sum.samples);
            squares += (got - want) * (got - want);
        } else {
            assert_eq!(got, want);
            assert!(sum.samples < 64, "{corner:?}: {}", sum.samples);
        }
    }
    let (each, error) = (samples / crossed, (squares / f64::from(crossed)).sqrt());
    assert!((8..=16).contains(&crossed), "{crossed}");
    // The error of n samples of a whole pixel is about n^(-3/4) / 4.
    let uniform = 0.25 * libm::pow(f64::from(each), -0.75);
    assert!(
        each < 512 && error < 0.3 * uniform,
        "{each} samples each, {error}, not below 0.3 x {uniform}"
    );
}

/// Checks that no more samples are requested than allowed, regardless of the threshold.
#[test]
fn noise_gets_all_samples_there_may_be() {
    let noise = |[x, y]: [f64; 2]| (libm::sin(x * 7919.0) * libm::cos(y * 104_729.0)) as f32;
    for (spp, each) in [(2, 2), (3, 2), (4, 4), (31, 16), (64, 64)] {
        let cells = sampled((spp, 1e-9), WHOLE, noise);
        assert_eq!(cells.samples.len(), 64 * each);
        // The numbers are those of the first uniform samples: each number once.
        let mut numbers: Vec<u32> = cells.pixels[9].halving.clone();
        numbers.sort_unstable();
        if each > 4 {
            assert!(numbers.iter().skip(1).copied().eq(1..each as u32));
        }
    }
}

#[test]
fn thresholds_order_the_samples() {
    let mut before = usize::MAX;
    for threshold in [1e-4, 1e-3, 1e-2, 1e-1, 1e3] {
        let count = sampled((1024, threshold), WHOLE, slanted).samples.len();
        assert!(count < before, "{threshold}: {count}, not below {before}");
        before = count;
    }
    assert_eq!(before, 256);
}

/// Known and visible lights of a requested sample, given the results of its neighbours for three
/// lights at a hit.
fn counted(votes: &[(u32, u32, u32)]) -> (u32, u32) {
    let sights = votes.iter().map(|&(path_id, requested, seen)| {
        let mut sights = [LightVisibility::default(); MAX_HITS];
        sights[1] = LightVisibility {
            path_id,
            queried: requested,
            visible: seen,
        };
        sights
    });
    let cells = Cells {
        visibility: sights.collect(),
        near: (0..votes.len() as u32).collect(),
        requests: vec![SampleRequest {
            pixel: (0, 0),
            number: 4,
            neighbours: 0..votes.len(),
        }],
        ..Cells::default()
    };
    assert_eq!(cells.known_lights(0, 0, 7), (0, 0));
    cells.known_lights(0, 1, 7)
}

#[test]
fn six_must_agree_about_a_light() {
    let (lit, dark, elsewhere) = ((7, 0b111, 0b011), (7, 0b111, 0b001), (8, 0b111, 0b100));
    assert_eq!(counted(&[lit; MIN_AGREEING - 1]), (0, 0));
    for count in MIN_AGREEING..20 {
        assert_eq!(counted(&vec![lit; count]), (0b111, 0b011), "{count}");
    }
    assert_eq!(counted(&[elsewhere; 9]), (0, 0));
    assert_eq!(
        counted(&[lit, lit, lit, elsewhere, elsewhere, elsewhere, lit, lit]),
        (0, 0)
    );
    // One of seven found the second light hidden.
    let mut mixed = [lit; 7];
    mixed[3] = dark;
    assert_eq!(counted(&mixed), (0b101, 0b001));
    // Samples that did not query a light do not count for it.
    let mut fewer = [lit; 6];
    fewer[5].1 = 0b101;
    assert_eq!(counted(&fewer), (0b101, 0b001));
}

#[test]
fn what_may_be_believed_shrinks_with_the_threshold_and_grows_with_halving() {
    let mut cells = Cells::default();
    let sizes = |cells: &Cells| {
        let believed = |most: &f32| cells.may_reuse(0, [0.0, *most, 0.0]);
        let sizes = (-24..24).map(|k| libm::exp2f(k as f32));
        sizes.take_while(believed).count()
    };
    for (halvings, threshold, count) in [(0, 1.0, 30), (0, 0.25, 28), (5, 0.25, 33)] {
        cells.begin(Adaptive { threshold }, 256, ((0, 0), (1, 1)), false);
        cells.samples[0].level = halvings;
        assert_eq!(sizes(&cells), count);
    }
    assert!(!cells.may_reuse(0, [f32::NAN, 0.0, 0.0]));
}

#[test]
fn trails_differ_by_what_was_hit_on_which_way() {
    let mut all: Vec<u32> = Vec::new();
    for prim in 0..100 {
        let first = path_id(0, 0, prim);
        all.push(first);
        for (hit, next) in (1..MAX_HITS).flat_map(|s| (0..100).map(move |next| (s, next))) {
            all.push(path_id(first, hit, next));
        }
    }
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count);
}
