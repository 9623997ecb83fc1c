//! How precisely an answer is asked for, as people type it.

use crate::run::Precision;

/// Largest precision that can be asked for.
const COARSEST: f64 = 0.5;

/// A precision: `0.2%`, `p95:1%`. Without the unit, 0.2 would be 0.2 % for some and 20 % for
/// others.
///
/// # Errors
/// What is allowed.
pub fn precision(text: &str) -> Result<Precision, String> {
    let allowed = || {
        let names = Precision::names().collect::<Vec<_>>().join(", ");
        format!(
            "allowed is a share up to 50%, as in 0.2%, or one of {names} before it, as in p95:1%"
        )
    };
    let (statistic, share) = text.split_once(':').unwrap_or(("mean", text));
    let number = share.strip_suffix('%').unwrap_or(share).trim();
    let wanted = number.parse::<f64>().map_err(|_| allowed())? * 0.01;
    if !(Precision::names().any(|name| name == statistic) && wanted > 0.0 && wanted <= COARSEST) {
        return Err(allowed());
    }
    if !share.ends_with('%') {
        return Err(format!("the unit is missing: type {text}%"));
    }
    Ok(Precision { of: statistic.to_owned(), wanted })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn precisions() {
        let read = |text| precision(text).map(|p| (p.of, p.wanted));
        assert_eq!(read("0.2%"), Ok(("mean".to_owned(), 0.002)));
        assert_eq!(read("p95:1%"), Ok(("p95".to_owned(), 0.01)));
        for text in ["", "%", "0", "-1%", "51%", "nan", "inf", "p96:1%", "p95", ":1%", "1%%"] {
            assert!(read(text).is_err_and(|message| message.contains("p95")), "{text}");
        }
        // 0.2 % to some, 20 % to others
        for (text, unit) in [("0.2", "type 0.2%"), ("p95:1", "type p95:1%")] {
            assert!(read(text).is_err_and(|error| error.contains(unit)), "{text}");
        }
    }
}
