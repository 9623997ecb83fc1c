//! A column in Arrow's form as numbers of 64 bits, or as texts.
//!
//! Arrow's own casts between any two of its types take a fifth of the time in which the package is
//! built, and a tenth of its size:
//! `docs/decisions/2026-11-25-columns-of-arrow-without-its-casts.md`.

use arrow_array::cast::AsArray;
use arrow_array::timezone::Tz;
use arrow_array::types::{
    Decimal32Type, Decimal64Type, Decimal128Type, Decimal256Type, DecimalType, Float16Type,
    Float32Type, Float64Type,
};
use arrow_array::{
    Array, Float64Array, StringArray, downcast_integer_array, downcast_temporal_array,
};
use arrow_schema::DataType;
use std::fmt::Debug;
use std::str::from_utf8;

/// Whether a type is one of numbers; a coded one is what its codes stand for.
pub(super) fn is_number(data_type: &DataType) -> bool {
    match data_type {
        DataType::Dictionary(_, values) => is_number(values),
        other => other.is_numeric(),
    }
}

/// A column of numbers, null where one is missing. Those of 64 bits are not copied. None where the
/// type is not one of numbers.
pub(super) fn numbers(column: &dyn Array) -> Option<Float64Array> {
    Some(downcast_integer_array!(
        column => column.unary(|number| number as f64),
        DataType::Float64 => column.as_primitive::<Float64Type>().clone(),
        DataType::Float32 => column.as_primitive::<Float32Type>().unary(f64::from),
        DataType::Float16 => column.as_primitive::<Float16Type>().unary(f64::from),
        DataType::Dictionary(..) => {
            let values = numbers(column.as_any_dictionary().values())?;
            let value = |k| values.is_valid(k).then(|| values.value(k));
            codes(column).map(|code| code.and_then(value)).collect()
        },
        other if other.is_decimal() => {
            let written = words(column)?;
            written.iter().map(|word| word.and_then(|word| word.parse::<f64>().ok())).collect()
        },
        _ => return None,
    ))
}

/// A column as texts, null where one is missing; numbers, dates and times are written. None where
/// a cell has parts, or is a span of time.
pub(super) fn words(column: &dyn Array) -> Option<StringArray> {
    Some(downcast_integer_array!(
        column => written(column.iter()),
        DataType::Null => StringArray::new_null(column.len()),
        DataType::Utf8 => column.as_string::<i32>().clone(),
        DataType::LargeUtf8 => column.as_string::<i64>().iter().collect(),
        DataType::Utf8View => column.as_string_view().iter().collect(),
        DataType::Binary => utf8(column.as_binary::<i32>().iter()),
        DataType::LargeBinary => utf8(column.as_binary::<i64>().iter()),
        DataType::BinaryView => utf8(column.as_binary_view().iter()),
        DataType::Boolean => written(column.as_boolean().iter()),
        DataType::Float64 => written(column.as_primitive::<Float64Type>().iter()),
        DataType::Float32 => written(column.as_primitive::<Float32Type>().iter()),
        DataType::Float16 => written(column.as_primitive::<Float16Type>().iter()),
        DataType::Decimal32(..) => decimals::<Decimal32Type>(column),
        DataType::Decimal64(..) => decimals::<Decimal64Type>(column),
        DataType::Decimal128(..) => decimals::<Decimal128Type>(column),
        DataType::Decimal256(..) => decimals::<Decimal256Type>(column),
        DataType::Dictionary(..) => {
            let values = words(column.as_any_dictionary().values())?;
            let value = |k| values.is_valid(k).then(|| values.value(k));
            codes(column).map(|code| code.and_then(value)).collect()
        },
        _ => return times(column),
    ))
}

/// The codes of a coded column, none where a cell is missing.
fn codes(column: &dyn Array) -> impl Iterator<Item = Option<usize>> {
    let coded = column.as_any_dictionary();
    // without a value there is no code
    let codes =
        if coded.values().is_empty() { vec![0; coded.len()] } else { coded.normalized_keys() };
    codes.into_iter().enumerate().map(|(i, code)| coded.keys().is_valid(i).then_some(code))
}

/// Dates, times of the day, and both together, with the offset from UTC where they have a zone.
fn times(column: &dyn Array) -> Option<StringArray> {
    let zone: Option<Tz> = match column.data_type() {
        DataType::Timestamp(_, Some(zone)) => Some(zone.parse().ok()?),
        _ => None,
    };
    downcast_temporal_array!(
        column => {
            let cell = |i| match (column.data_type(), zone) {
                (DataType::Date32, _) => column.value_as_date(i).map(|date| format!("{date:?}")),
                (DataType::Time32(_) | DataType::Time64(_), _) => {
                    column.value_as_time(i).map(|time| format!("{time:?}"))
                }
                (_, Some(zone)) => {
                    column.value_as_datetime_with_tz(i, zone).map(|time| time.to_rfc3339())
                }
                _ => column.value_as_datetime(i).map(|time| format!("{time:?}")),
            };
            let valid = |i: usize| if column.is_valid(i) { cell(i) } else { None };
            Some((0..column.len()).map(valid).collect())
        }
        _ => None,
    )
}

fn written<T: Debug>(cells: impl Iterator<Item = Option<T>>) -> StringArray {
    cells.map(|cell| cell.map(|cell| format!("{cell:?}"))).collect()
}

fn utf8<'a>(cells: impl Iterator<Item = Option<&'a [u8]>>) -> StringArray {
    cells.map(|cell| cell.and_then(|bytes| from_utf8(bytes).ok())).collect()
}

fn decimals<T: DecimalType>(column: &dyn Array) -> StringArray {
    let column = column.as_primitive::<T>();
    let cells = 0..column.len();
    cells.map(|i| column.is_valid(i).then(|| column.value_as_string(i))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::types::{Int8Type, Int32Type};
    use arrow_array::*;
    use std::sync::Arc;

    fn told(column: &dyn Array) -> Vec<Option<String>> {
        let words = words(column).expect("a column of cells");
        words.iter().map(|word| word.map(str::to_owned)).collect()
    }

    /// Each with a cell, a missing one, and another cell.
    #[test]
    fn cells_of_all_types_are_written() {
        let decimal = Decimal128Array::from(vec![Some(1250), None, Some(-7)]);
        let decimal = decimal.with_precision_and_scale(10, 2).expect("in range");
        let zoned = |zone| {
            let stamps = vec![Some(1_704_067_200_500), None, Some(0)];
            TimestampMillisecondArray::from(stamps).with_timezone(zone)
        };
        let cases: [(ArrayRef, [&str; 2]); 15] = [
            (Arc::new(Int8Array::from(vec![Some(-5), None, Some(7)])), ["-5", "7"]),
            (
                Arc::new(UInt64Array::from(vec![Some(u64::MAX), None, Some(0)])),
                ["18446744073709551615", "0"],
            ),
            (Arc::new(Float64Array::from(vec![Some(1.0), None, Some(0.1)])), ["1.0", "0.1"]),
            (Arc::new(Float32Array::from(vec![Some(0.1), None, Some(f32::NAN)])), ["0.1", "NaN"]),
            (Arc::new(decimal), ["12.50", "-0.07"]),
            (Arc::new(BooleanArray::from(vec![Some(true), None, Some(false)])), ["true", "false"]),
            (Arc::new(StringArray::from(vec![Some("a"), None, Some("")])), ["a", ""]),
            (Arc::new(LargeStringArray::from(vec![Some("a"), None, Some("b")])), ["a", "b"]),
            (Arc::new(StringViewArray::from(vec![Some("a"), None, Some("b")])), ["a", "b"]),
            (Arc::new(BinaryArray::from(vec![Some(&b"a"[..]), None, Some(b"b")])), ["a", "b"]),
            (
                Arc::new(Date32Array::from(vec![Some(19_723), None, Some(0)])),
                ["2024-01-01", "1970-01-01"],
            ),
            (
                Arc::new(Time32SecondArray::from(vec![Some(3_661), None, Some(0)])),
                ["01:01:01", "00:00:00"],
            ),
            (
                Arc::new(TimestampSecondArray::from(vec![Some(1_704_067_200), None, Some(0)])),
                ["2024-01-01T00:00:00", "1970-01-01T00:00:00"],
            ),
            (
                Arc::new(zoned("+02:00")),
                ["2024-01-01T02:00:00.500+02:00", "1970-01-01T02:00:00+02:00"],
            ),
            (
                Arc::new(
                    [Some("b"), None, Some("a")].into_iter().collect::<DictionaryArray<Int8Type>>(),
                ),
                ["b", "a"],
            ),
        ];
        for (column, [first, last]) in cases {
            let wanted = [Some(first.to_owned()), None, Some(last.to_owned())];
            assert_eq!(told(&column), wanted, "{}", column.data_type());
        }
        assert_eq!(told(&NullArray::new(2)), [None, None]);
    }

    #[test]
    fn numbers_of_all_types_are_numbers() {
        let decimal = Decimal128Array::from(vec![Some(125), None, Some(-7)]);
        let decimal = decimal.with_precision_and_scale(10, 2).expect("in range");
        let values = Arc::new(Float64Array::from(vec![Some(-0.07), Some(1.25), None]));
        let keys = Int8Array::from(vec![Some(1), Some(2), Some(0)]);
        let coded = DictionaryArray::<Int8Type>::try_new(keys, values).expect("codes of values");
        let float = Float32Array::from(vec![Some(1.25), None, Some(-0.07)]);
        let cases: [(ArrayRef, f64); 3] = [
            (Arc::new(decimal), -0.07),
            (Arc::new(coded), -0.07),
            (Arc::new(float), f64::from(-0.07_f32)),
        ];
        for (column, last) in cases {
            assert!(is_number(column.data_type()));
            let values = numbers(&column).expect("numbers");
            let wanted = Float64Array::from(vec![Some(1.25), None, Some(last)]);
            assert_eq!(values, wanted, "{}", column.data_type());
        }
        let integers = Int32Array::from(vec![Some(i32::MIN), None, Some(3)]);
        let wanted = Float64Array::from(vec![Some(-2_147_483_648.0), None, Some(3.0)]);
        assert_eq!(numbers(&integers), Some(wanted));
        assert_eq!(numbers(&StringArray::from(vec!["1"])), None);
    }

    #[test]
    fn codes_without_values_are_missing_and_cells_of_parts_are_none() {
        let keys = Int8Array::from(vec![None, None]);
        let values = Arc::new(StringArray::new_null(0));
        let coded = DictionaryArray::<Int8Type>::try_new(keys, values).expect("no code");
        assert_eq!(told(&coded), [None, None]);
        let lists = ListArray::from_iter_primitive::<Int32Type, _, _>([Some([Some(1)])]);
        assert_eq!(words(&lists), None);
        assert_eq!(words(&DurationSecondArray::from(vec![1])), None);
        let zone = TimestampSecondArray::from(vec![0]).with_timezone("nowhere");
        assert_eq!(words(&zone), None);
    }
}
