//! Numbers as people read them: three digits and a unit.

/// `value` with `digits` significant digits; all digits before the point stay.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    // The exponent after rounding, so that 9.996 becomes 10.0 and not 10.00.
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let exponent: i32 = scientific
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0);
    if exponent < -5 {
        return scientific;
    }
    let decimals = usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0);
    format!("{value:.decimals$}")
}

/// Digits and SI unit of a time in nanoseconds.
fn time_parts(nanoseconds: f64) -> (String, &'static str) {
    let mut unit = ("ns", 1.0);
    for next in [("µs", 1e3), ("ms", 1e6), ("s", 1e9)] {
        // From where three digits would round up to the next unit's first.
        if nanoseconds >= next.1 * 0.9995 {
            unit = next;
        }
    }
    (significant(nanoseconds / unit.1, 3), unit.0)
}

/// A time in nanoseconds, such as `1.23 µs`.
pub fn time(nanoseconds: f64) -> String {
    let (digits, unit) = time_parts(nanoseconds);
    format!("{digits} {unit}")
}

/// A time in nanoseconds without a space, such as `1.23µs`.
pub fn time_tight(nanoseconds: f64) -> String {
    let (digits, unit) = time_parts(nanoseconds);
    format!("{digits}{unit}")
}

/// A whole or round time for an axis, such as `10 µs`.
pub fn time_tick(nanoseconds: f64) -> String {
    let (digits, unit) = time_parts(nanoseconds);
    format!("{} {unit}", trimmed(&digits))
}

/// Seconds, such as `0.212 s` or `1.2 ms`.
pub fn seconds(seconds: f64) -> String {
    if seconds == 0.0 {
        "0 s".to_owned()
    } else if seconds >= 0.1 {
        format!("{} s", significant(seconds, 3))
    } else {
        time(seconds * 1e9)
    }
}

/// The share below which an error is shown as none: what f32 arithmetic may leave.
pub const EXACT: f64 = 1e-5;

/// A share in per cent without the sign; `<0.001` between nothing and that.
pub fn percent(share: f64) -> String {
    if share == 0.0 {
        "0".to_owned()
    } else if share.abs() < EXACT {
        "<0.001".to_owned()
    } else if share < 0.001 {
        // A thousandth of a per cent is the last digit shown.
        format!("{:.3}", share * 100.0)
    } else {
        significant(share * 100.0, 3)
    }
}

/// `value` with three digits, in powers of ten below a thousandth.
pub fn precise(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 {
        format!("{value:.1e}")
    } else {
        significant(value, 3)
    }
}

/// A round share for an axis, such as `0.1 %`.
pub fn percent_tick(share: f64) -> String {
    format!("{} %", trimmed(&significant(share * 100.0, 3)))
}

/// A size σ, or any number that is meant to be round: without needless zeros.
pub fn plain(value: f64) -> String {
    trimmed(&significant(value, 4))
}

fn trimmed(digits: &str) -> String {
    if digits.contains('.') && !digits.contains('e') {
        digits
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned()
    } else {
        digits.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_and_the_unit_that_fits() {
        let times = [0.5, 9.996, 999.4, 999.6, 1234.0, 56_780.0, 2.5e6, 3e9].map(time);
        let expected = [
            "0.500 ns", "10.0 ns", "999 ns", "1.00 µs", "1.23 µs", "56.8 µs", "2.50 ms", "3.00 s",
        ];
        assert_eq!(times, expected.map(String::from));
        assert_eq!(time_tight(1234.0), "1.23µs");
        assert_eq!(time_tick(20_000.0), "20 µs");
        assert_eq!(time_tick(100.0), "100 ns");
        assert_eq!(seconds(0.2124), "0.212 s");
        assert_eq!(seconds(0.0012), "1.20 ms");
        assert_eq!(seconds(0.0), "0 s");
    }

    #[test]
    fn shares_keep_what_matters() {
        let shares = [0.0, 1e-9, 0.000_123, 0.012_34, 0.5, 2.0].map(percent);
        assert_eq!(
            shares,
            ["0", "<0.001", "0.012", "1.23", "50.0", "200"].map(String::from)
        );
        assert_eq!(
            [0.0001, 0.1, 1.0].map(percent_tick),
            ["0.01 %", "10 %", "100 %"]
        );
        assert_eq!(
            [0.5, 16.0, 0.0025, 300.0].map(plain),
            ["0.5", "16", "0.0025", "300"]
        );
        assert_eq!(significant(1.5e-7, 3), "1.50e-7");
        assert_eq!(
            [0.0, 1.24e-5, 0.012_34].map(precise),
            ["0", "1.2e-5", "0.0123"]
        );
        assert_eq!(significant(123_456.0, 3), "123456");
    }
}
