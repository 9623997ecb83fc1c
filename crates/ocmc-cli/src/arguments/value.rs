//! How numbers are typed, and which are allowed.

use ocmc_api::{LAST_CYCLE_ID, MOST_THREADS, Precision, UTC_OFFSETS_H};

/// Most cycles that can be driven at a time by a thread.
const LARGEST_CHUNK: u64 = 65_536;

/// Largest precision that can be asked for.
const COARSEST: f64 = 0.5;

/// A precision: `0.2%`, `p95:1%`. Without the unit, 0.2 would be 0.2 % for some and 20 % for
/// others.
pub(super) fn precision(text: &str) -> Result<Precision, String> {
    let allowed = || {
        let names = Precision::names().collect::<Vec<_>>().join(", ");
        format!(
            "allowed is a share up to 50%, as in 0.2%, or one of {names} before it, as in p95:1%"
        )
    };
    let (of, share) = text.split_once(':').unwrap_or(("mean", text));
    let number = share.strip_suffix('%').unwrap_or(share).trim();
    let wanted = number.parse::<f64>().map_err(|_| allowed())? * 0.01;
    if !(Precision::names().any(|name| name == of) && wanted > 0.0 && wanted <= COARSEST) {
        return Err(allowed());
    }
    if !share.ends_with('%') {
        return Err(format!("the unit is missing: type --precision {text}%"));
    }
    Ok(Precision { of: of.to_owned(), wanted })
}

/// A whole number from 0 on; `10_000` is one, too.
pub(super) fn whole_number(text: &str) -> Result<u64, String> {
    let digits = text.replace('_', "");
    let allowed = || format!("allowed is a whole number from 0 to {}", u64::MAX);
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(allowed());
    }
    digits.parse().map_err(|_| allowed())
}

/// A number of cycles: as many as there are ids.
pub(super) fn at_least_one(text: &str) -> Result<u64, String> {
    match whole_number(text) {
        Ok(number) if (1..=LAST_CYCLE_ID).contains(&number) => Ok(number),
        _ => Err(format!("allowed is a whole number from 1 to {LAST_CYCLE_ID}")),
    }
}

/// Most cycles of a crossed design: the values of all of them are held in memory, once for each
/// driver.
const MOST_CROSSED: u64 = 1_000_000;

/// A number of cycles whose variance can be split.
pub(super) fn crossed(text: &str) -> Result<u64, String> {
    match whole_number(text) {
        Ok(number) if (2..=MOST_CROSSED).contains(&number) => Ok(number),
        _ => Err(format!("allowed is a whole number from 2 to {MOST_CROSSED}")),
    }
}

/// An id after which there is another number, so that a run of this cycle alone ends at a number.
pub(super) fn cycle_id(text: &str) -> Result<u64, String> {
    match whole_number(text) {
        Ok(id) if id < LAST_CYCLE_ID => Ok(id),
        _ => Err(format!("allowed is a whole number from 0 to {}", LAST_CYCLE_ID - 1)),
    }
}

/// Cycles that a thread drives at a time: their records wait in memory.
pub(super) fn chunk(text: &str) -> Result<u64, String> {
    match whole_number(text) {
        Ok(number) if (1..=LARGEST_CHUNK).contains(&number) => Ok(number),
        _ => Err(format!("allowed is a whole number from 1 to {LARGEST_CHUNK}")),
    }
}

/// By how many hours a standard time is ahead of UTC.
pub(super) fn utc_offset_h(text: &str) -> Result<f64, String> {
    let hours = text.parse().ok().filter(|hours| UTC_OFFSETS_H.contains(hours));
    let [least, most] = [UTC_OFFSETS_H.start(), UTC_OFFSETS_H.end()];
    hours.ok_or_else(|| format!("allowed are hours from {least} to {most}"))
}

pub(super) fn threads(text: &str) -> Result<usize, String> {
    let number = whole_number(text).ok().and_then(|number| usize::try_from(number).ok());
    let number = number.filter(|number| (1..=MOST_THREADS).contains(number));
    number.ok_or_else(|| format!("allowed is a whole number from 1 to {MOST_THREADS}"))
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
        for (text, unit) in [("0.2", "--precision 0.2%"), ("p95:1", "--precision p95:1%")] {
            assert!(read(text).is_err_and(|error| error.contains(unit)), "{text}");
        }
    }

    #[test]
    fn numbers() {
        assert_eq!(whole_number("10_000"), Ok(10_000));
        assert_eq!(whole_number("18446744073709551615"), Ok(u64::MAX));
        for text in ["", "_", "-1", "+1", "1.5", "1e3", "18446744073709551616", "x"] {
            assert!(whole_number(text).is_err(), "{text}");
        }
        assert_eq!(at_least_one("288230376151711743"), Ok(LAST_CYCLE_ID));
        for text in ["0", "288230376151711744"] {
            assert!(
                at_least_one(text).is_err_and(|message| message.contains("288230376151711743"))
            );
        }
        assert_eq!(crossed("2"), Ok(2));
        for text in ["1", "1000001", "99999999999999", "x"] {
            assert!(crossed(text).is_err_and(|message| message.contains("2 to 1000000")), "{text}");
        }
        assert!(threads("0").is_err() && threads("1025").is_err() && threads("1024").is_ok());
    }
}
