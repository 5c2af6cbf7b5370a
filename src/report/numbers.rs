//! Numbers as text: as many digits as they are worth, with their unit. On pages, NaN and infinity
//! become a dash.

/// Text instead of a missing number.
pub const NONE: &str = "–";

/// Narrow space that does not break, between the digits of long numbers and before units.
pub(super) const THIN: char = '\u{202f}';

/// A rate with three significant digits, which is what it is worth.
pub fn rate(mrays: f64) -> String {
    let decimals = match mrays {
        r if r >= 99.95 => 0,
        r if r >= 9.995 => 1,
        _ => 2,
    };
    format!("{mrays:.decimals$}")
}

/// A share as a signed percentage: -0.148 is `-14.8 %`.
pub(super) fn signed_percent(share: f64) -> String {
    // A number that rounds to zero has no sign.
    let tenths = (share * 1000.0).round() / 10.0;
    if tenths == 0.0 {
        return "0.0 %".to_owned();
    }
    format!("{tenths:+.1} %")
}

/// A threshold as it was given: 0.0005 is `0.05 %`.
pub(super) fn threshold(share: f64) -> String {
    let percent = format!("{:.6}", 100.0 * share);
    format!("{} %", percent.trim_end_matches('0').trim_end_matches('.'))
}

/// `scenes`, or `scene` if there is one.
pub fn plural(count: usize, noun: &str) -> String {
    let end = if count == 1 { "" } else { "s" };
    format!("{noun}{end}")
}

/// `3 scenes`, `1 scene`.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {}", plural(count, noun))
}

/// Like [`counted`], with a page's narrow spaces.
pub(super) fn page_counted(number: usize, noun: &str) -> String {
    format!("{}{THIN}{}", count(number as u64), plural(number, noun))
}

/// About three digits, for anything measured.
pub(super) fn measured(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if !value.is_finite() => NONE.to_owned(),
        1000.0.. => grouped(&format!("{value:.0}"), THIN),
        100.0.. => format!("{value:.0}"),
        10.0.. => format!("{value:.1}"),
        0.1.. => format!("{value:.2}"),
        0.001.. => format!("{value:.4}"),
        _ if size == 0.0 => "0".to_owned(),
        _ => format!("{value:.1e}"),
    }
}

/// An integer in groups of three digits.
pub(super) fn count(value: u64) -> String {
    grouped(&value.to_string(), THIN)
}

/// A count short enough for an axis: 20k, 1.5M.
pub(super) fn short(value: f64) -> String {
    let steps = [(1e9, "G"), (1e6, "M"), (1e3, "k")];
    match steps.iter().find(|(step, _)| value >= *step) {
        _ if !value.is_finite() => NONE.to_owned(),
        Some((step, unit)) => format!("{}{unit}", at_most_three(value / step)),
        None => at_most_three(value),
    }
}

/// A number along an axis, with as many decimals as its steps have.
pub(super) fn step(value: f64, step: f64) -> String {
    let decimals = match step {
        1.0.. => 0,
        0.1.. => 1,
        0.01.. => 2,
        _ => 3,
    };
    // Negative zero becomes zero.
    let value = value + 0.0;
    format!("{value:.decimals$}")
}

/// Up to three digits, none of them a zero at the end.
fn at_most_three(value: f64) -> String {
    let text = match value.abs() {
        100.0.. => return format!("{value:.0}"),
        10.0.. => format!("{value:.1}"),
        1.0.. => format!("{value:.2}"),
        _ => return format!("{value}"),
    };
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_owned()
}

/// A duration.
pub(super) fn seconds(value: f64) -> String {
    let (number, unit) = match value.abs() {
        60.0.. => (value / 60.0, "min"),
        1.0.. => (value, "s"),
        0.001.. => (value * 1e3, "ms"),
        _ => (value * 1e6, "µs"),
    };
    known(value, || format!("{}{THIN}{unit}", measured(number)))
}

/// Bytes in the unit that gives one to four digits before the decimal point: `3.0 MiB`.
pub fn bytes(number: u64) -> String {
    let mut amount = number as f64 / 1024.0;
    let mut unit = "KiB";
    for larger in ["MiB", "GiB"] {
        if amount >= 1024.0 {
            (amount, unit) = (amount / 1024.0, larger);
        }
    }
    format!("{amount:.1} {unit}")
}

/// A size on a page, in powers of 1000.
pub(super) fn decimal_bytes(value: u64) -> String {
    scaled_bytes(value, 1000.0, ["B", "kB", "MB", "GB", "TB"])
}

/// A size on a page, in powers of 1024, as caches and memory are.
pub(super) fn binary_bytes(value: u64) -> String {
    scaled_bytes(value, 1024.0, ["B", "KiB", "MiB", "GiB", "TiB"])
}

fn scaled_bytes(value: u64, step: f64, units: [&str; 5]) -> String {
    let mut unit = 0;
    let mut number = value as f64;
    while number >= step && unit + 1 < units.len() {
        number /= step;
        unit += 1;
    }
    format!("{}{THIN}{}", short(number), units[unit])
}

/// A ratio, as a multiple.
pub(super) fn times(value: f64) -> String {
    known(value, || format!("{}×", measured(value)))
}

/// A share, as per cent.
pub(super) fn percent(share: f64) -> String {
    let value = share * 100.0;
    known(value, || match value.abs() {
        10.0.. => format!("{value:.0}{THIN}%"),
        0.1.. => format!("{value:.1}{THIN}%"),
        _ if value == 0.0 => format!("0{THIN}%"),
        _ => format!("{value:.3}{THIN}%"),
    })
}

/// The text of a number, or a dash where it is none.
pub(super) fn known(value: f64, text: impl FnOnce() -> String) -> String {
    if value.is_finite() { text() } else { NONE.to_owned() }
}

/// Digits in threes from the right; a sign stays where it is.
pub fn grouped(digits: &str, separator: char) -> String {
    let (sign, digits) = match digits.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", digits),
    };
    let mut text = String::from(sign);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(separator);
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: String) -> String {
        text.replace(THIN, " ")
    }

    #[test]
    fn numbers_as_text() {
        assert_eq!(signed_percent(-0.1484), "-14.8 %");
        assert_eq!(signed_percent(0.0321), "+3.2 %");
        assert_eq!(signed_percent(-0.0001), "0.0 %");
        assert_eq!(
            [rate(123.4), rate(99.96), rate(12.34), rate(1.234)],
            ["123", "100", "12.3", "1.23"]
        );
        assert_eq!(threshold(0.0005), "0.05 %");
        assert_eq!(counted(1, "row") + " " + &counted(0, "row"), "1 row 0 rows");
    }

    #[test]
    fn bytes_get_a_fitting_unit() {
        let cases = [
            (512, "0.5 KiB"),
            (3 << 20, "3.0 MiB"),
            (5 << 40, "5120.0 GiB"),
        ];
        for (number, text) in cases {
            assert_eq!(bytes(number), text);
        }
    }

    #[test]
    fn numbers_have_the_digits_they_are_worth() {
        for (value, want) in [
            (12345.6, "12 346"),
            (-1234.0, "-1 234"),
            (123.4, "123"),
            (12.34, "12.3"),
            (1.234, "1.23"),
            (0.1234, "0.12"),
            (0.0123, "0.0123"),
            (0.0, "0"),
            (1.5e-7, "1.5e-7"),
            (f64::NAN, "–"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(plain(measured(value)), want);
        }
        assert_eq!(plain(count(1_234_567)), "1 234 567");
        assert_eq!(
            [
                short(1_500_000.0),
                short(20_000.0),
                short(0.05),
                short(f64::NAN)
            ],
            ["1.5M", "20k", "0.05", "–"]
        );
        assert_eq!(plain(binary_bytes(48 << 10)), "48 KiB");
        assert_eq!(plain(decimal_bytes(0)), "0 B");
        assert_eq!(plain(seconds(0.0123)), "12.3 ms");
        assert_eq!(plain(seconds(f64::NAN)), "–");
        assert_eq!(plain(percent(0.000_123)), "0.012 %");
    }
}
