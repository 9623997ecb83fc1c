//! Matching of VECTO's results to missions, and their load and auxiliaries.

use super::error::ComparisonError;
use crate::file::{Job, Series, Sum, read_series, read_sums};
use ocmc_core::vehicle::resistance::GRAVITY_MPS2;
use std::path::{Path, PathBuf};

/// Slope work below which a series says nothing of the mass, in m²/s² times s.
const LEAST_SLOPE: f64 = 1.0;

/// A result and the mission that it is of.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) mission: String,
    pub(super) mission_file: Option<PathBuf>,
    pub(super) gross_mass_kg: f64,
    pub(super) auxiliary_w: f64,
    pub(super) result: Result,
}

/// Result of VECTO.
#[derive(Clone, Debug)]
pub(super) enum Result {
    Series(PathBuf, Series),
    Sum(Sum),
}

/// The results with their missions, in the order of the results.
pub(super) fn cases(
    missions: &[PathBuf],
    results: &[PathBuf],
    job: Option<&Job>,
) -> std::result::Result<Vec<Case>, ComparisonError> {
    let (mut cases, mut sums, mut rows) = (Vec::new(), None, Vec::new());
    let beside = || job.map_or_else(Vec::new, |job| series_of(job.path()));
    let paths = if results.is_empty() { beside() } else { results.to_vec() };
    for path in &paths {
        if ending(path) == "vsum" {
            sums = Some(path);
            for sum in read_sums(path)? {
                rows.push(sum.mission.clone());
                let stem = plain(&file_stem(Path::new(&sum.mission)));
                let mission_file = missions.iter().find(|file| plain(&file_stem(file)) == stem);
                if missions.is_empty() || mission_file.is_some() {
                    cases.push(Case {
                        mission: format!("{}: {}", sum.name, sum.mission),
                        mission_file: mission_file.cloned(),
                        gross_mass_kg: sum.gross_mass_kg,
                        auxiliary_w: sum.auxiliary_j / sum.time_s,
                        result: Result::Sum(sum),
                    });
                }
            }
            continue;
        }
        let name = without_job(&plain(&file_stem(path)), job);
        let fits = |file: &&PathBuf| name.contains(&plain(&file_stem(file)));
        // the longest name is the closest: `level` is in `level 5kW`
        let mission_file = missions.iter().filter(fits).max_by_key(|file| file_stem(file).len());
        if !missions.is_empty() && mission_file.is_none() {
            if results.is_empty() {
                continue;
            }
            return Err(ComparisonError::Mission(path.clone()));
        }
        let series = read_series(path)?;
        let gross_mass_kg = job.and_then(Job::gross_mass_kg).or_else(|| mass_kg(&series));
        cases.push(Case {
            mission: file_stem(path),
            mission_file: mission_file.cloned(),
            gross_mass_kg: gross_mass_kg.ok_or_else(|| ComparisonError::Mass(path.clone()))?,
            auxiliary_w: auxiliary_w(&series),
            result: Result::Series(path.clone(), series),
        });
    }
    if cases.is_empty() {
        let (Some(sums), Some(mission)) = (sums, missions.first()) else {
            return Err(ComparisonError::NoResult);
        };
        rows.sort();
        rows.dedup();
        let (mission, sums, rows) = (mission.clone(), sums.clone(), rows.join("`, `"));
        return Err(ComparisonError::Row { mission, sums, rows });
    }
    Ok(cases)
}

fn series_of(job: &Path) -> Vec<PathBuf> {
    let Some(folder) = job.parent() else { return Vec::new() };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let files = std::fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<PathBuf> = files.filter_map(|entry| Some(entry.ok()?.path())).collect();
    let name = |path: &Path| plain(&file_stem(path));
    let jobs = files.iter().filter(|file| ending(file) == "vecto").map(|file| name(file));
    let jobs: Vec<String> = jobs.collect();
    let own = name(job);
    let is_own = |series: &Path| {
        let series = name(series);
        let longest =
            jobs.iter().filter(|job| series.starts_with(job.as_str())).max_by_key(|job| job.len());
        longest.map_or(jobs.len() < 2, |longest| *longest == own)
    };
    files.retain(|file| ending(file) == "vmod" && is_own(file));
    files.sort();
    files
}

/// Mass of the truck of a series, in kg, to whole ones: gravity's power over g v sin θ.
fn mass_kg(series: &Series) -> Option<f64> {
    let (mut power, mut lift) = (0.0, 0.0);
    for second in &series.seconds {
        let sine = second.gradient / (1.0 + second.gradient * second.gradient).sqrt();
        let weight = second.speed_mps * sine;
        power += second.grade_w * weight;
        lift += GRAVITY_MPS2 * weight * weight;
    }
    // VECTO's g has two places
    let rounded = (power / lift / 9.81 * GRAVITY_MPS2).round();
    (lift > LEAST_SLOPE).then_some(rounded)
}

/// Mean power of the auxiliaries, in W.
fn auxiliary_w(series: &Series) -> f64 {
    let sum: f64 = series.seconds.iter().map(|second| second.auxiliary_w).sum();
    sum / series.seconds.len() as f64
}

/// The name of a result without that of its job, in which other missions may be named.
fn without_job(name: &str, job: Option<&Job>) -> String {
    let job = job.map(|job| plain(&file_stem(job.path()))).unwrap_or_default();
    name.strip_prefix(&job).unwrap_or(name).to_owned()
}

/// A name in letters and digits.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The name of a file without its endings.
fn file_stem(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into());
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

/// The ending of a file, behind which `.gz` does not count.
fn ending(path: &Path) -> String {
    let name =
        path.file_name().map_or_else(String::new, |name| name.to_string_lossy().to_lowercase());
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map_or("", |(_, ending)| ending).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_job_has_the_series_that_begin_with_its_name() {
        let folder = tempfile::tempdir().expect("a directory");
        let path = |name: &str| folder.path().join(name);
        let own = |job: &str| -> Vec<String> {
            fs::write(path(job), "{}").expect("space");
            series_of(&path(job)).iter().map(|file| file_stem(file)).collect()
        };
        // of a single job in the folder all are its own, whatever they are called
        fs::write(path("40t Truck_Long_Haul.vmod"), "").expect("space");
        fs::write(path("old.vmod.gz"), "").expect("space");
        assert_eq!(own("40t_Truck.vecto"), ["40t Truck_Long_Haul", "old"]);
        // a job without series has none of its neighbour's
        assert_eq!(own("40t_Truck_AirDrag.vecto"), [""; 0]);
        assert_eq!(own("40t_Truck.vecto"), ["40t Truck_Long_Haul"]);
        fs::write(path("40t_Truck_AirDrag_Long_Haul.vmod"), "").expect("space");
        assert_eq!(own("40t_Truck_AirDrag.vecto"), ["40t_Truck_AirDrag_Long_Haul"]);
        assert_eq!(own("40t_Truck.vecto"), ["40t Truck_Long_Haul"]);
    }
}
