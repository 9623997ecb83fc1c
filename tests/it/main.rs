//! Tests of the whole program: one executable.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "a test fails by panic, compares bits, and prints its figures"
)]

mod adjusted_means;
mod bad_input;
mod battery;
mod battery_temperature;
mod benchmark;
mod bound;
mod breakdown;
mod calibrate_totals;
mod calibration;
mod chain;
mod charging;
mod charging_decision;
mod charging_limits;
mod checksums;
mod closed_form;
mod closed_loop;
mod closing_the_loop;
mod command_line;
mod common;
mod cost;
mod determinism;
mod doubt;
mod drawn_parts;
mod electric;
mod energy_balance;
mod fit;
mod fit_fleet;
mod fleet_answers;
mod fleet_nesting;
mod follow_speed;
mod forces;
mod free_flow_clock;
mod fuel_cell;
mod given_cycles;
mod gross_mass;
mod hints;
mod identification;
mod intake;
mod learn;
mod loads;
mod logs;
mod look_ahead;
mod map_corners;
mod merge;
mod mission_parts;
mod noisy_routes;
mod odd_inputs;
mod others_data;
mod parts;
mod precision;
mod prescribed;
mod program;
mod random_studies;
mod range;
mod report;
mod rest;
mod resume;
mod road_rows;
mod roads_from_logs;
mod run_directory;
mod sampling;
mod sensitivity;
mod service_mode;
mod shift_strategy;
mod signals;
mod simulator_study;
mod size;
mod small_faults;
mod speed_ahead;
mod step_bias;
mod stop_plans;
mod sweep;
mod tables;
mod tactical;
mod training;
mod uncertainty;
mod validation;
mod vecto;
mod vecto_files;
mod whole_trip;
