//! The parts of a study that files tell by a fit.

use super::LearnRequest;
use super::read::Read;
use crate::answer::Answer;
use crate::error::Error;
use crate::fit::{
    CurveSpeedOptions, CurveSpeedRequest, FitAnswer, SpeedChangeOptions, SpeedChangeRequest,
    TrafficRequest, WeatherRequest, fit_curve_speed, fit_speed_change, fit_traffic, fit_weather,
    roads_part,
};
use crate::source::Source;
use crate::totals_rows::{empirical, thinned};
use crate::watch::Watch;
use ocmc_core::study::StudyModel;
use ocmc_io::export::{ExportKind, has_limits};
use ocmc_io::number_text::count_of;
use ocmc_io::study::{LoadedStudy, StudyFileError, StudyPart, load_text, study_of_parts};
use serde::Serialize;
use serde_json::{Value, json};
use std::slice::from_ref;

const SECONDS_PER_DAY: f64 = 86_400.0;
/// Fewest roads that a road model is fitted to, and fewest departures (judgement).
const FEWEST: usize = 20;

/// A fit that was tried.
#[derive(Clone, Debug, Serialize)]
pub struct LearntPart {
    /// Name of the part of the study.
    pub what: &'static str,
    /// The command that does the same alone.
    pub command: &'static str,
    /// Names of its sources.
    pub sources: String,
    /// Why its numbers stay those of the base.
    pub refused: Option<String>,
}

/// The fits, and the study with them.
pub(super) struct Fits {
    pub(super) parts: Vec<LearntPart>,
    pub(super) written: Vec<StudyPart>,
    /// Warnings of the fits, each behind the name of its part.
    pub(super) warnings: Vec<String>,
    pub(super) study: LoadedStudy,
}

impl Fits {
    /// Fits what can be fitted, `all` of it or without the drives that are held back.
    pub(super) fn of(
        request: &LearnRequest,
        read: &Read,
        all: bool,
        watch: &mut Watch,
    ) -> Result<Self, Error> {
        let (_, base) = &request.base;
        let (parts, written, warnings) = (Vec::new(), Vec::new(), Vec::new());
        let mut fits = Self { parts, written, warnings, study: (*base).clone() };
        fits.roads(request, read, all);
        fits.departures(request, read);
        let of_kind = |kind| read.of_kind(&request.folder, kind);
        let (mappings, model) = (request.mappings.clone(), &base.model);
        let weather = of_kind(ExportKind::Weather);
        if !weather.is_empty() {
            let question = WeatherRequest {
                tables: &weather,
                mappings: mappings.clone(),
                base: model,
                place: None,
            };
            let fitted = fit_weather(&question).map(values);
            fits.add(request, "weather", "fit weather", &weather, fitted);
        }
        if let Some(table) =
            fits.first("traffic", "fit traffic", of_kind(ExportKind::Traffic), request)
        {
            let mappings = mappings.clone();
            let question =
                TrafficRequest { table: table.clone(), mappings, base: model, place: None };
            let fitted = fit_traffic(&question).map(values);
            fits.add(request, "traffic", "fit traffic", &[table], fitted);
        }
        let curves = of_kind(ExportKind::Curves);
        if let Some(curves) = fits.first("curve speeds", "fit curve-speed", curves, request) {
            let (mappings, options) = (mappings.clone(), CurveSpeedOptions::default());
            let question = CurveSpeedRequest {
                curves: curves.clone(),
                mappings,
                base: model,
                options,
                tobit: false,
            };
            let fitted = fit_curve_speed(&question).map(values);
            fits.add(request, "curve speeds", "fit curve-speed", &[curves], fitted);
        }
        let mut changes = of_kind(ExportKind::SpeedChanges);
        let limited = |source: &Source| has_limits(source.path(), &mappings);
        changes.extend(of_kind(ExportKind::Log).into_iter().filter(limited));
        let mut fit = |tables: &[Source]| {
            let question = SpeedChangeRequest {
                tables,
                mappings: mappings.clone(),
                base: model,
                options: SpeedChangeOptions::default(),
                untruncated: true,
            };
            match fit_speed_change(&question, &mut |_| (), watch) {
                Err(error @ Error::Interrupted(_)) => Err(error),
                fitted => Ok(fitted.map(values)),
            }
        };
        // a file that tells nothing does not keep the others from telling something
        let (mut telling, mut silent, mut reason) = (Vec::new(), Vec::new(), None);
        for file in changes {
            match fit(from_ref(&file))? {
                Ok(_) => telling.push(file),
                Err(error) => {
                    silent.push(file);
                    reason = reason.or(Some(error));
                }
            }
        }
        let (what, command) = ("speed changes", "fit speed-change");
        if !telling.is_empty() {
            let fitted = fit(&telling)?;
            fits.add(request, what, command, &telling, fitted);
        }
        if let Some(reason) = reason {
            fits.add(request, what, command, &silent, Err(reason));
        }
        Ok(fits)
    }

    /// The first of some tables of which a fit takes one; the others are named.
    fn first(
        &mut self,
        what: &'static str,
        command: &'static str,
        mut tables: Vec<Source>,
        request: &LearnRequest,
    ) -> Option<Source> {
        let others = tables.split_off(tables.len().min(1));
        if !others.is_empty() {
            let sources = named(request, &others);
            let refused = Some("one table is fitted: join them in one".to_owned());
            self.parts.push(LearntPart { what, command, sources, refused });
        }
        tables.pop()
    }

    /// The laws of departures that the totals have.
    fn departures(&mut self, request: &LearnRequest, read: &Read) {
        let Some((table, source)) = &read.totals else { return };
        let known: Vec<f64> = table.rows.iter().map(|row| row.s_of_year).collect();
        let known: Vec<f64> = known.into_iter().filter(|s| s.is_finite()).collect();
        let seconds: Vec<f64> = known.iter().map(|s| s % SECONDS_PER_DAY).collect();
        // dates without a clock are midnights
        let is_timed = seconds.iter().any(|second| *second != 0.0);
        if 2 * known.len() < table.rows.len() || known.len() < FEWEST || !is_timed {
            return;
        }
        let days = known.iter().map(|s| libm::floor(s / SECONDS_PER_DAY)).collect();
        let values = json!({ "mission": {
            "departure_s_of_day": empirical(&thinned(seconds, 1.0)),
            "departure_day_of_year": empirical(&thinned(days, 1.0)),
        } });
        let source = [Source::File(source.clone())];
        self.add(request, "departures", "learn", &source, Ok((values, Vec::new())));
    }

    /// Fits the whole model of roads with limits; of fewer, and of others, hills and missions.
    fn roads(&mut self, request: &LearnRequest, read: &Read, all: bool) {
        let limited = read.limited.joined(all);
        let is_whole = limited.roads.len() >= FEWEST;
        let mut roads = limited;
        if !is_whole {
            roads.append(read.unlimited.joined(all));
        }
        if roads.roads.is_empty() {
            return;
        }
        let sources = count_of(roads.roads.len() as u64, "road");
        let what = if is_whole { "roads and missions" } else { "hills and missions" };
        let command = "fit operating-cycle";
        if roads.roads.len() < FEWEST {
            let reason = format!(
                "a road model of so few is further off than the one that is judged, which totals \
                 can still move; allowed are {FEWEST} or more"
            );
            self.parts.push(LearntPart { what, command, sources, refused: Some(reason) });
            return;
        }
        let model: &StudyModel = &request.base.1.model;
        let fitted = roads_part(&roads, None, model, &request.folder).map(|(fit, part)| {
            let warnings: Vec<String> = fit.warnings.into_iter().chain(part.warnings()).collect();
            if is_whole {
                return (part.json(), warnings);
            }
            let of_hills = |words: &String| !words.contains("curves") && !words.contains("signs");
            (hills_and_missions(part.json()), warnings.into_iter().filter(of_hills).collect())
        });
        self.tried(request, (what, command), sources, fitted);
    }

    fn add(
        &mut self,
        request: &LearnRequest,
        what: &'static str,
        command: &'static str,
        files: &[Source],
        fitted: Result<ValuesAndNotes, Error>,
    ) {
        self.tried(request, (what, command), named(request, files), fitted);
    }

    /// Lays a part over the study, where there is one and the rest goes with it.
    fn tried(
        &mut self,
        request: &LearnRequest,
        (what, command): (&'static str, &'static str),
        sources: String,
        fitted: Result<ValuesAndNotes, Error>,
    ) {
        let with = fitted.map_err(|error| error.to_string()).and_then(|(values, warnings)| {
            self.warnings.extend(warnings.into_iter().map(|words| format!("{what}: {words}")));
            let part = StudyPart { command, sources: sources.clone(), values };
            let mut parts = self.written.clone();
            parts.push(part);
            let study = laid(request, &parts);
            study.map(|(_, study)| (parts, study)).map_err(|error| error.to_string())
        });
        let refused = match with {
            Ok((parts, study)) => {
                (self.written, self.study) = (parts, study);
                None
            }
            Err(reason) => Some(reason),
        };
        self.parts.push(LearntPart { what, command, sources, refused });
    }
}

/// A file by its name below the folder, or how many files there are.
fn named(request: &LearnRequest, files: &[Source]) -> String {
    match files {
        [only] => {
            let path = only.path().strip_prefix(&request.folder).unwrap_or(only.path());
            format!("`{}`", path.display())
        }
        files => count_of(files.len() as u64, "file"),
    }
}

/// The text of the study with parts laid over the base; and the study as it is driven here, without
/// the errors of its numbers, each of which makes two studies more.
pub(super) fn laid(
    request: &LearnRequest,
    parts: &[StudyPart],
) -> Result<(String, LoadedStudy), StudyFileError> {
    let sources = format!("`{}`", request.folder.display());
    let text = |parts: &[StudyPart]| {
        study_of_parts(&request.base.0, &request.name, ("learn", &sources), parts)
    };
    let certain = parts.iter().cloned().map(|mut part| {
        part.values.as_object_mut().map(|values| values.remove("uncertainty"));
        part
    });
    let (certain, _) = text(&certain.collect::<Vec<_>>())?;
    let study = load_text("the learnt study", &certain, &[] as &[&str])?;
    Ok((text(parts)?.0, study))
}

/// The part of a road model that tracks without limits tell: the limits of their speed have told
/// the types of their roads, of which they know the hills; such limits are no signs, and change
/// more often than the types of roads do.
fn hills_and_missions(mut values: Value) -> Value {
    let is_told = |key: &str| key.starts_with("mission.") || key.contains(".topography.");
    if let Some(road) = values.get_mut("road").and_then(Value::as_object_mut) {
        road.retain(|key, _| key == "types");
        for road_type in road.values_mut().filter_map(Value::as_object_mut) {
            for law in road_type.values_mut().filter_map(Value::as_object_mut) {
                law.retain(|key, _| key == "topography");
            }
        }
    }
    let errors = values.pointer_mut("/uncertainty/road").and_then(Value::as_object_mut);
    if let Some(errors) = errors {
        let told: Vec<bool> = (errors["keys"].as_array().into_iter().flatten())
            .map(|key| key.as_str().is_some_and(is_told))
            .collect();
        for list in ["keys", "standard_errors"] {
            let mut is_told = told.iter();
            if let Some(list) = errors.get_mut(list).and_then(Value::as_array_mut) {
                list.retain(|_| *is_told.next().unwrap_or(&false));
            }
        }
        if !told.contains(&true) {
            values.as_object_mut().map(|values| values.remove("uncertainty"));
        }
    }
    values
}

/// Values of a part, and what is odd in them.
type ValuesAndNotes = (Value, Vec<String>);

fn values<Fit: Serialize>(answer: FitAnswer<Fit>) -> ValuesAndNotes {
    let warnings = answer.warnings();
    (answer.study, warnings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_without_limits_tell_hills_and_missions() {
        let told = hills_and_missions(json!({
            "mission": { "length_m": 5e4 },
            "road": {
                "junction_turn": { "median_radius_m": 12.0 },
                "types": { "urban": { "topography": { "slope_sd": 0.02 }, "mean_length_m": 4e3 } },
            },
            "uncertainty": { "road": {
                "keys": ["road.types.urban.mean_length_m", "road.types.urban.topography.slope_sd"],
                "standard_errors": [1.0, 2.0],
            } },
        }));
        let expected = json!({
            "mission": { "length_m": 5e4 },
            "road": { "types": { "urban": { "topography": { "slope_sd": 0.02 } } } },
            "uncertainty": { "road": {
                "keys": ["road.types.urban.topography.slope_sd"], "standard_errors": [2.0],
            } },
        });
        assert_eq!(told, expected);
        assert_eq!(hills_and_missions(json!({ "mission": {} })), json!({ "mission": {} }));
    }
}
