//! A first program: the mean consumption of a few trips, and how long one of them takes.
//! `scripts/first-program` builds it as a stranger does, and checks what it prints.

#![allow(clippy::print_stdout, reason = "it is a program")]

use ocmc_api::{Answer, Error, GivenDrive, RunPlan, RunRequest, go_on, run, study, trace};

fn main() -> Result<(), Error> {
    let study = &study::load("field-truck", &[] as &[&str])?;
    let (given, plan) = (&GivenDrive::nothing(), RunPlan::new(1, 0, 8, Some(2), None));
    let request = RunRequest { study, given, plan, precision: None, out: None };
    let answer = run(&request, &mut |_| (), &mut go_on)?;
    println!("{}", answer.to_json());
    let series = trace(study, 1, 7);
    println!("cycle 7 takes {:.0} s", series.columns[0].values.last().unwrap_or(&0.0));
    Ok(())
}
