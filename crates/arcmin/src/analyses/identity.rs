use sha2::{Digest, Sha256};

use super::{Analysis, AnalysisError, Host, NormalOptions, Origin};
use crate::design::{Design, InputFile};

/// Identity of a run: the SHA-256 of analysis, design, options with their defaults, the content of every
/// input file, and the version of the program. Runs with the same identity have the same results.
///
/// # Errors
/// Options that are wrong, files that cannot be read.
pub fn identity(
    analysis: &Analysis,
    design: &Design,
    options: &str,
    origin: &str,
    host: &dyn Host,
) -> Result<String, AnalysisError> {
    let normal = analysis.normal_options(options, origin)?;
    let flanks = design.measured_flanks().into_iter().map(|flank| InputFile(flank.file)).collect();
    identity_of(analysis.name, &design.canonical(), &normal, flanks, host)
}

/// [`identity`] by the canonical text of any design and the flanks that it names.
pub(super) fn identity_of(
    analysis: &str,
    design: &str,
    options: &NormalOptions,
    flanks: Vec<InputFile>,
    host: &dyn Host,
) -> Result<String, AnalysisError> {
    let mut hash = Sha256::new();
    // Each text is preceded by its length, so that different lists of texts give different bytes.
    let mut put = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    put(env!("CARGO_PKG_VERSION").as_bytes());
    put(analysis.as_bytes());
    put(design.as_bytes());
    // Continuing from a checkpoint does not change the results.
    let lines = options.text.lines().filter(|line| !line.starts_with("resume = "));
    put(lines.collect::<Vec<_>>().join("\n").as_bytes());
    for file in &options.files {
        put(&host.read(file, Origin::Options)?);
    }
    for flank in flanks {
        match host.read(&flank, Origin::Design) {
            // Checks report missing and invalid files themselves.
            Err(error) if analysis == "check" => put(error.to_string().as_bytes()),
            content => put(&content?),
        }
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
