use super::*;

const NONE_FLOOR: OutputEncoding = OutputEncoding {
    transfer: Transfer::None,
    quantize: Quantize::Floor,
};

/// The red samples of a one-row film.
fn samples(values: &[f32], transfer: Transfer, quantize: Quantize) -> Vec<u8> {
    let film = Film {
        width: values.len() as u32,
        height: 1,
        planes: [
            values.to_vec(),
            vec![0.0; values.len()],
            vec![1.0; values.len()],
        ],
        aovs: Default::default(),
        aov_planes: Vec::new(),
        hits: None,
    };
    let picture = encode(&film, OutputEncoding { transfer, quantize });
    assert_eq!(picture.rgb.len(), 3 * values.len());
    for pixel in picture.rgb.chunks_exact(3) {
        assert_eq!(pixel[1..], [0, 255]);
    }
    picture.rgb.iter().step_by(3).copied().collect()
}

const ODD: [f32; 7] = [
    f32::NAN,
    -1.0,
    -0.0,
    f32::NEG_INFINITY,
    f32::INFINITY,
    2.0,
    1.0,
];

#[test]
fn values_outside_the_unit_interval_are_clamped_and_nan_is_black() {
    for transfer in [Transfer::None, Transfer::Srgb] {
        for quantize in [Quantize::Floor, Quantize::Round] {
            let got = samples(&ODD, transfer, quantize);
            assert_eq!(
                got,
                [0, 0, 0, 0, 255, 255, 255],
                "{transfer:?} {quantize:?}"
            );
        }
    }
}

#[test]
fn without_transfer_the_sample_is_floor_or_nearest_of_255_c() {
    // 255 · 0.5 = 127.5; 255 · 0.998 = 254.49; 0.2 is an f32 just above 1/5, so that 255 · 0.2
    // is 51.
    let values = [0.5, 0.998, 0.999, 0.2, 0.001];
    assert_eq!(
        samples(&values, Transfer::None, Quantize::Floor),
        [127, 254, 254, 51, 0]
    );
    assert_eq!(
        samples(&values, Transfer::None, Quantize::Round),
        [128, 254, 255, 51, 0]
    );
}

#[test]
fn srgb_gives_known_values() {
    // 0.5 encodes to 187.516, 0.18 to 117.65, 0.002 (the straight part) to 6.589, 0.9999 to
    // 254.99.
    let values = [0.5, 0.18, 0.002, 0.9999];
    assert_eq!(
        samples(&values, Transfer::Srgb, Quantize::Floor),
        [187, 117, 6, 254]
    );
    assert_eq!(
        samples(&values, Transfer::Srgb, Quantize::Round),
        [188, 118, 7, 255]
    );
}

#[test]
fn srgb_thresholds_agree_with_the_forward_curve() {
    let forward = |c: f64| match c {
        c if c <= 0.003_130_8 => 255.0 * 12.92 * c,
        c => 255.0 * (1.055 * libm::pow(c, 1.0 / 2.4) - 0.055),
    };
    for (quantize, offset) in [(Quantize::Floor, 0.0), (Quantize::Round, 0.5)] {
        let thresholds = srgb_thresholds(quantize);
        assert!(thresholds.windows(2).all(|w| w[0] < w[1]));
        for (i, &least) in thresholds.iter().enumerate() {
            let position = forward(least) + offset;
            // The two published constants of the joint differ in the eighth digit.
            assert!(
                (position - (i + 1) as f64).abs() < 1e-3,
                "{quantize:?} {i}: {position}"
            );
        }
    }
}

/// Checks values next to every threshold, at every cell's ends, and over the whole range.
#[test]
fn the_table_counts_thresholds() {
    for quantize in [Quantize::Floor, Quantize::Round] {
        let thresholds = srgb_thresholds(quantize);
        let table = SrgbTable::new(&thresholds);
        let cells = (0..=TABLE_CELLS).map(|cell| cell as f32 / TABLE_CELLS as f32);
        let near = thresholds.map(|t| t as f32).into_iter().chain(cells);
        let near = near.flat_map(|c| [c.next_down().next_down(), c.next_down(), c, c.next_up()]);
        let all = (0..3_000_000).map(|k| k as f32 / 2_900_000.0);
        for c in near.chain(all).chain(ODD) {
            let value = f64::from(unit(c));
            let want = thresholds.partition_point(|&least| least <= value);
            assert_eq!(usize::from(table.sample(c)), want, "{quantize:?} {c:e}");
        }
    }
}

#[test]
fn sixteen_bits_are_thresholds_at_or_below() {
    for quantize in [Quantize::Floor, Quantize::Round] {
        let table = DeepTable::new(quantize);
        assert!(table.next.windows(2).all(|w| w[0] < w[1]));
        let near = table
            .next
            .iter()
            .flat_map(|&t| [t.next_down(), t, t.next_up()]);
        let ends = (0..=TABLE_CELLS).map(|cell| cell as f32 / TABLE_CELLS as f32);
        let all = (0..300_000).map(|k| k as f32 / 290_000.0);
        for c in near.chain(ends).chain(all).chain(ODD) {
            let value = f64::from(unit(c));
            let want = match value {
                v if v <= 0.003_130_8 => 12.92 * v,
                v => 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055,
            };
            let want = 65_535.0 * want + f64::from(u8::from(quantize == Quantize::Round)) * 0.5;
            let got = f64::from(table.sample(c));
            // Next to a threshold, the forward curve is off by the difference of the published
            // constants.
            assert!(
                got <= want + 0.02 && got > want - 1.02,
                "{quantize:?} {c:e}: {got} {want}"
            );
        }
    }
    let srgb = OutputEncoding {
        transfer: Transfer::Srgb,
        quantize: Quantize::Round,
    };
    // 0.5 encodes to 0.735356983.
    let rgb_16 = |encoding: OutputEncoding| {
        Encoder::new(encoding.into()).rgb_16([&[0.5], &[1.0], &[f32::NAN]])
    };
    assert_eq!(rgb_16(srgb), [48_192, 65_535, 0]);
    assert_eq!(rgb_16(NONE_FLOOR), [32_767, 65_535, 0]);
}

#[test]
fn a_stop_is_a_factor_of_two() {
    let film = Film {
        width: 3,
        height: 1,
        planes: [vec![0.1, 0.2, 0.4], vec![1e38; 3], vec![f32::NAN; 3]],
        aovs: Default::default(),
        aov_planes: Vec::new(),
        hits: None,
    };
    let red = |exposure| {
        let grade = Exposure {
            stops: exposure,
            ..NONE_FLOOR.into()
        };
        let rgb = encode(&film, grade).rgb;
        assert_eq!(rgb[1..3], [255, 0]);
        [rgb[0], rgb[3], rgb[6]]
    };
    assert_eq!(red(0.0), [25, 51, 102]);
    assert_eq!(red(1.0), [51, 102, 204]);
    assert_eq!(red(-1.0), [12, 25, 51]);
    // The root of two times 51.
    assert_eq!(red(0.5)[1], 72);
    assert_eq!(red(30.0), [255; 3]);
}

#[test]
fn the_curve_comes_between_exposure_and_transfer() {
    let odd = [f32::NAN, -1.0, f32::NEG_INFINITY];
    let values = [0.02, 0.3, 0.7, 1.0, 4.0, f32::INFINITY]
        .into_iter()
        .chain(odd);
    let red: Vec<f32> = values.collect();
    let [green, blue] = [0.1, 0.4].map(|c| vec![c; red.len()]);
    let planes = [&red[..], &green, &blue];
    for encoding in [OutputEncoding::SRGB, NONE_FLOOR] {
        let toned = Exposure {
            stops: 1.5,
            curve: ToneCurve::Neutral,
            encoding,
        };
        let map = toned.mapping();
        let mapped: Vec<_> = (0..red.len())
            .map(|k| map([red[k], green[k], blue[k]]))
            .collect();
        let mapped = [0, 1, 2].map(|c| mapped.iter().map(|rgb| rgb[c]).collect::<Vec<_>>());
        let (got, plain) = (Encoder::new(toned), Encoder::new(encoding.into()));
        let mapped = mapped.each_ref().map(Vec::as_slice);
        assert_eq!(got.rgb_8(planes), plain.rgb_8(mapped));
        assert_eq!(got.rgb_16(planes), plain.rgb_16(mapped));
        // NaN and negative radiance are black with either curve.
        let black = [
            toned,
            Exposure {
                curve: ToneCurve::Linear,
                ..toned
            },
        ]
        .map(|exposure| Encoder::new(exposure).rgb_8([&odd, &odd, &odd]));
        assert_eq!(black, [vec![0; 9], vec![0; 9]]);
    }
}

/// The contract "same bytes on every build": these are the expected bits of the table.
#[test]
fn srgb_thresholds_are_pinned_bit_for_bit() {
    let hash = |quantize| {
        let bytes = srgb_thresholds(quantize).map(f64::to_bits);
        bytes
            .iter()
            .flat_map(|b| b.to_le_bytes())
            .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| {
                (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
            })
    };
    assert_eq!(hash(Quantize::Floor), PIN_FLOOR);
    assert_eq!(hash(Quantize::Round), PIN_ROUND);
}

const PIN_FLOOR: u64 = 5_556_954_415_098_186_741;
const PIN_ROUND: u64 = 1_944_805_278_954_198_400;

#[test]
fn pixels_keep_their_order() {
    let film = Film {
        width: 2,
        height: 1,
        planes: [vec![0.1, 0.4], vec![0.2, 0.5], vec![0.3, 0.6]],
        aovs: Default::default(),
        aov_planes: Vec::new(),
        hits: None,
    };
    assert_eq!(encode(&film, NONE_FLOOR).rgb, [25, 51, 76, 102, 127, 153]);
}
