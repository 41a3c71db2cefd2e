//! Analyses and their results: one module per analysis.
//!
//! Every analysis takes a [`Design`] and options, uses its [`Host`] for files, progress and cancellation, and
//! returns an [`Outcome`] that owns all its data: tables, summary, report page, terminal text, and a verdict
//! where there is one. Command line, studies, Python and FMUs call the same [`run`](Analysis::run); the meaning
//! of options and the names of results are defined only here.
//!
//! ```
//! use arcmin::analyses::{NoHost, contact};
//!
//! let design = arcmin::templates::design("rv-40e-81").unwrap();
//! let options = contact::Options::parse("torque_nm = 100", "example")?;
//! let outcome = contact::run(&design, &options, &NoHost)?;
//! println!("{:.0} N at most", outcome.max_force());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod calibrate;
mod causes;
pub mod check;
pub mod contact;
mod elastic_disc;
mod error;
mod errors_table;
mod host;
mod identity;
pub mod inputs;
pub mod joint;
pub mod life;
pub mod like;
pub mod multibody;
mod outcome;
pub mod profile;
pub mod propose;
pub mod rig;
pub mod simulate;
pub mod stage;
pub mod tao2024;
pub mod wear;

pub use causes::CausesAt;
pub use error::AnalysisError;
pub use host::{Host, NoHost, OnlyResults, Origin, Quiet};
pub use identity::identity;
pub(crate) use outcome::outcome;
pub use outcome::{Attachment, Outcome, TextBlock, TextTable};

use crate::design::{Design, InputFile, OptionSet, SectionSchema};
use crate::results::Declared;

/// An analysis for its callers: name, options and function.
pub struct Analysis {
    /// The word of the command.
    pub name: &'static str,
    /// Answer in one line.
    pub about: &'static str,
    /// Description for its help.
    pub guide: &'static str,
    /// Command lines to start from.
    pub examples: &'static [&'static str],
    /// Documentation of its options.
    pub options: fn() -> &'static SectionSchema,
    run: fn(&Design, &str, &str, &dyn Host) -> Result<Box<dyn Outcome>, AnalysisError>,
    normal: fn(&str, &str) -> Result<NormalOptions, AnalysisError>,
    /// Documentation of its results.
    pub results: fn() -> Declared,
}

/// Options in a form that does not depend on how they were written.
pub struct NormalOptions {
    /// One `key = value` a line, defaults included.
    pub text: String,
    /// The files that they name.
    pub files: Vec<InputFile>,
}

impl NormalOptions {
    fn of(options: &impl OptionSet) -> NormalOptions {
        let mut files = Vec::new();
        options.files(&mut files);
        NormalOptions { text: options.canonical(), files }
    }
}

impl Analysis {
    /// Runs the analysis with options written as TOML; `origin` names them in messages.
    ///
    /// # Errors
    /// [`AnalysisError`]: options that are wrong, files that cannot be read, questions that cannot be
    /// answered.
    pub fn run(
        &self,
        design: &Design,
        options: &str,
        origin: &str,
        host: &dyn Host,
    ) -> Result<Box<dyn Outcome>, AnalysisError> {
        (self.run)(design, options, origin, host)
    }

    /// The options as read, defaults filled in.
    ///
    /// # Errors
    /// Options that are wrong.
    pub fn normal_options(&self, options: &str, origin: &str) -> Result<NormalOptions, AnalysisError> {
        (self.normal)(options, origin)
    }
}

macro_rules! analyses {
    ($($module:ident,)*) => {
        /// All analyses, in the usual order of use.
        pub static ALL: &[Analysis] = &[$(Analysis {
            name: stringify!($module),
            about: $module::ABOUT,
            guide: $module::GUIDE,
            examples: $module::EXAMPLES,
            options: <$module::Options as OptionSet>::schema,
            run: |design, options, origin, host| {
                let options = $module::Options::parse(options, origin)?;
                Ok(Box::new($module::run(design, &options, host)?))
            },
            normal: |options, origin| Ok(NormalOptions::of(&$module::Options::parse(options, origin)?)),
            results: || Declared {
                analysis: stringify!($module),
                about: $module::ABOUT,
                tables: $module::tables(),
                summary: $module::SUMMARY.quantities(),
            },
        },)*];
    };
}

analyses! {
    check,
    profile,
    contact,
    wear,
    calibrate,
    simulate,
    rig,
    life,
    tao2024,
}

/// An analysis by its name.
pub fn by_name(name: &str) -> Option<&'static Analysis> {
    ALL.iter().find(|analysis| analysis.name == name)
}

#[cfg(test)]
mod tests;
