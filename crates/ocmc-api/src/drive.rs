//! Drives that replace a study's own roads: given routes, or a speed that is followed.
//!
//! [`GivenDrive::read`] reads files, [`GivenDrive::of_table`] takes a table; [`crate::run`] drives
//! either.
//!
//! ```
//! use ocmc_api::{Follow, GivenDrive, RunPlan, RunRequest, go_on, run, study};
//! let folder = tempfile::tempdir().expect("a directory");
//! let file = folder.path().join("speed.csv");
//! let speeds = "time_s,speed_mps,grade\n0,0,0\n40,20,0\n160,20,0\n180,0,0\n";
//! std::fs::write(&file, speeds).expect("space");
//! let (files, follow) = (vec![file], Some(Follow::Exact));
//! let given = &GivenDrive::read(files, Vec::new(), Vec::new(), Vec::new(), None, follow)?;
//! let study = &study::load("field-truck-loaded", &[] as &[&str])?;
//! let plan = RunPlan::new(1, 0, 4, None, None);
//! let request = RunRequest { study, given, plan, precision: None, out: None };
//! let answer = run(&request, &mut |_| (), &mut go_on)?;
//! assert_eq!(answer.summary.summary.distance_m, 4.0 * 3000.0);
//! # Ok::<(), ocmc_api::Error>(())
//! ```

pub use ocmc_core::operating_cycle::drawn_part::Draw;
pub use ocmc_core::operating_cycle::route::{Keep, RouteModel};
pub use ocmc_io::given_cycle::{Account, check_readable};
pub use ocmc_io::given_drive::{Follow, GivenDrive, GivenDriveError};
