use crate::failure::Failure;
use crate::run::{Verdict, say};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Prints every key of the design file with its unit, range, default and meaning, in Markdown.",
    after_help = "Examples:\n  arcmin keys | less\n  arcmin keys | grep -i clearance"
)]
pub struct Options {}

pub fn run(_: Options) -> Result<Verdict, Failure> {
    say(arcmin::design::reference_of_keys().trim_end());
    Ok(Verdict::Fine)
}
