//! Numbers as people read them.

/// A whole number with commas between thousands.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Whether this is a number with a decimal comma, as in 2,5.
pub(crate) fn has_decimal_comma(text: &str) -> bool {
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let unsigned = text.trim_start_matches(['-', '+']);
    unsigned.split_once(',').is_some_and(|(whole, part)| digits(whole) && digits(part))
}

/// Whether this is a number with a unit behind it, as in 250m or 80 km/h.
pub(crate) fn has_unit(text: &str) -> bool {
    let text = text.trim();
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | '_' | '-' | '+');
    let number = text.trim_start_matches(digits);
    number.len() < text.len()
        && text.contains(|c: char| c.is_ascii_digit())
        && number.trim_start().starts_with(|c: char| c.is_alphabetic() || c == '%')
}

/// So many things: `1 row`, `1,200 rows`.
pub fn count_of(number: u64, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {thing}{plural}", grouped(number))
}

/// A share in per cent, to a tenth; what rounds to nothing has no sign.
pub fn percent(share: f64) -> String {
    let text = format!("{:.1}", 100.0 * share);
    if text == "-0.0" { "0.0".to_owned() } else { text }
}

/// A share in per cent, with its interval where there is one.
pub fn share_text(share: f64, ci95: Option<[f64; 2]>) -> String {
    match ci95 {
        Some([low, high]) => format!("{} ({} to {})", percent(share), percent(low), percent(high)),
        None => percent(share),
    }
}

/// A quantity rounded to about four digits, with commas from a thousand on.
pub fn rounded(number: f64) -> String {
    if number.abs() >= 1000.0 {
        let sign = if number < 0.0 { "-" } else { "" };
        return format!("{sign}{}", grouped(number.abs().round() as u64));
    }
    format!("{number:.*}", decimals(number))
}

/// A quantity rounded to three digits, for what is not the same twice.
pub fn rough(number: f64) -> String {
    if !number.is_finite() {
        return "-".to_owned();
    }
    let digits = format!("{number:.2e}").parse().unwrap_or(number);
    if digits >= 100.0 { grouped(digits as u64) } else { digits.to_string() }
}

/// A percentage to two digits.
pub fn rounded_share(percent: f64) -> String {
    format!("{percent:.1e}").parse::<f64>().unwrap_or(percent).to_string()
}

/// A duration, in s, to the hundredth.
pub fn short(seconds: f64) -> String {
    if seconds < 100.0 { format!("{seconds:.2}") } else { grouped(seconds as u64) }
}

/// Decimals with which a number has about four digits.
pub fn decimals(number: f64) -> usize {
    match number.abs() {
        size if size >= 1000.0 || !size.is_finite() => 0,
        size if size >= 100.0 => 1,
        size if size >= 10.0 => 2,
        size if size >= 1.0 => 3,
        _ => 4,
    }
}

/// A positive number with two digits.
pub fn two_digits(number: f64) -> String {
    let digits = if number > 0.0 { (1.0 - number.log10().floor()).clamp(0.0, 6.0) } else { 1.0 };
    format!("{number:.0$}", digits as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1234567, "1,234,567")] {
            assert_eq!(grouped(number), text);
        }
    }

    #[test]
    fn units_behind_numbers() {
        assert!(["250m", "-80 km/h", "0.5%", "1_000kg"].iter().all(|text| has_unit(text)));
        assert!(
            !["250", "2,5", "m", "", "-", "log_normal", "2024-01-01"]
                .iter()
                .any(|text| has_unit(text))
        );
    }

    #[test]
    fn one_thing_and_several() {
        for (number, text) in [(0, "0 rows"), (1, "1 row"), (1200, "1,200 rows")] {
            assert_eq!(count_of(number, "row"), text);
        }
    }

    #[test]
    fn nothing_has_no_sign() {
        for (share, text) in [(-0.0003, "0.0"), (-0.0, "0.0"), (-0.001, "-0.1"), (1.083, "108.3")] {
            assert_eq!(percent(share), text);
        }
    }

    #[test]
    fn three_digits() {
        for (number, text) in
            [(2635629.0, "2,640,000"), (436.3, "436"), (12.345, "12.3"), (f64::INFINITY, "-")]
        {
            assert_eq!(rough(number), text);
        }
    }

    #[test]
    fn four_digits() {
        for (number, text) in
            [(31.2468, "31.25"), (0.07126, "0.0713"), (-1234.4, "-1,234"), (812.34, "812.3")]
        {
            assert_eq!(rounded(number), text);
        }
    }
}
