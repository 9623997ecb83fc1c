//! What an identification says: a line for each event, what the data do not tell, and a table to
//! paste into a study.

use ocmc_estimation::identification::identify::{DriverParameterFit, EventFit};
use ocmc_estimation::identification::population::Population;
use std::fmt::Write;

/// The whole answer.
pub(crate) fn text(fits: &[EventFit], population: Option<&Population>) -> String {
    let mut text = String::new();
    for fit in fits {
        let _ = writeln!(
            text,
            "driver {}, event {} ({:.0} s): pedals within {:.4} rms, {} of {} starts agree, condition {:.0}",
            fit.driver,
            fit.event,
            fit.duration_s,
            fit.pedal_rms,
            fit.starts_converged,
            fit.starts,
            fit.condition
        );
        for parameter in &fit.parameters {
            line(&mut text, parameter);
        }
        if fit.saturated_s > 0.0 {
            let _ = writeln!(text, "  a pedal is fully pressed for {:.1} s", fit.saturated_s);
        }
    }
    match population {
        None => {
            text.push_str(
                "\nno population: it takes three drivers with a PID whose K_P and K_I are identified\n",
            );
        }
        Some(population) => table(&mut text, population),
    }
    text
}

fn line(text: &mut String, parameter: &DriverParameterFit) {
    let (label, unit) = match parameter.name {
        "kp" => ("K_P", "s/m"),
        "ki" => ("K_I", "1/m"),
        "kd" => ("K_D", "s²/m"),
        "threshold_mps" => ("threshold", "m/s"),
        "set_speed_mps" => ("set speed", "m/s"),
        "start_integral" => ("integral part at the start", ""),
        name => (name, ""),
    };
    let _ = write!(text, "  {label} = {:.4}", parameter.value);
    if let Some([low, high]) = parameter.interval {
        let _ = write!(text, " ({low:.4}; {high:.4})");
    }
    if !unit.is_empty() {
        let _ = write!(text, " {unit}");
    }
    if let Some(why) = parameter.not_identifiable {
        let _ = write!(text, ": not identifiable, {why}");
    }
    text.push('\n');
}

/// The population as a table of a study.
fn table(text: &mut String, population: &Population) {
    // bounds that hardly cut the law
    let three = (3.0 * population.proportional_log_sd).exp();
    let _ = write!(
        text,
        "\n# {} drivers, {} fits; {} left out because K_P or K_I is not identified\n\
         # spread of ln K_P between the events of a driver: {:.2}\n\
         [driver.pedals.pid]\n\
         proportional_median = {:.4}\n\
         proportional_log_sd = {:.3}\n\
         proportional_minimum = {:.4}\n\
         proportional_maximum = {:.4}\n\
         integral_time_median_s = {:.2}\n\
         integral_time_log_sd = {:.3}\n",
        population.drivers,
        population.fits,
        population.left_out,
        population.proportional_within_log_sd,
        population.proportional_median,
        population.proportional_log_sd,
        population.proportional_median / three,
        population.proportional_median * three,
        population.integral_time_median_s,
        population.integral_time_log_sd,
    );
    match (population.derivative_median, population.derivative_log_sd) {
        (Some(median), Some(sd)) => {
            let _ = writeln!(text, "derivative_median = {median:.4}\nderivative_log_sd = {sd:.3}");
        }
        _ => text.push_str("# K_D is identified for too few drivers: the study's own law stays\n"),
    }
    let [pi, pd, id] = population.correlation;
    let _ = writeln!(text, "correlation = [{pi:.2}, {pd:.2}, {id:.2}]");
}
