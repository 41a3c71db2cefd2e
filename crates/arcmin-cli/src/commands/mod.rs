//! One file per command: its options (whose comments are its help) and a function `run`. A new command is a
//! file and a line below.

use crate::failure::Failure;
use crate::run::Verdict;

mod calibrate;
mod causes;
mod check;
mod contact;
mod deviations;
mod elastic;
mod joints;
mod keys;
mod life;
mod new;
mod profile;
mod rig;
mod simulate;
mod wear;

macro_rules! commands {
    ($($(#[doc = $doc:literal])* $Name:ident => $module:ident,)*) => {
        #[derive(Debug, clap::Subcommand)]
        pub enum Command {
            $($(#[doc = $doc])* $Name(Box<$module::Options>),)*
        }

        impl Command {
            pub fn run(self) -> Result<Verdict, Failure> {
                match self {
                    $(Command::$Name(options) => $module::run(*options),)*
                }
            }
        }
    };
}

commands! {
    /// Write a commented design file to start from
    New => new,
    /// Print the reference of all keys of the design file
    Keys => keys,
    /// Judge a design: findings with value, limit, reason and remedy
    Check => check,
    /// Compute the flank of the cycloid disc: points, normals, curvature
    Profile => profile,
    /// Share the load among the pins over one turn of the crankshaft
    Contact => contact,
    /// Wear the flanks over the hours of service
    Wear => wear,
    /// Fit the wear coefficient to measured depths or lost motion
    Calibrate => calibrate,
    /// The main job: accuracy over life, with all figures in one report
    Life => life,
    /// Integrate the equations of motion: transmission error in time
    Simulate => simulate,
    /// Test bench: hysteresis loop, lost motion, stiffness, transmission error, efficiency
    Rig => rig,
}
