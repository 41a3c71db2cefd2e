use sha2::{Digest, Sha256};

use super::{Analysis, AnalysisError, Host, Origin};
use crate::design::{Design, InputFile};

/// Identity of a run: the SHA-256 of analysis, design, options with their defaults, the content of every
/// input file, and the version of the program. Equal identities, equal results.
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
    let mut hash = Sha256::new();
    // Lengths in front keep two texts from running into each other.
    let mut put = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    put(env!("CARGO_PKG_VERSION").as_bytes());
    put(analysis.name.as_bytes());
    put(design.canonical().as_bytes());
    // Whether a run goes on from a checkpoint changes nothing of what it computes.
    let lines = normal.text.lines().filter(|line| !line.starts_with("resume = "));
    put(lines.collect::<Vec<_>>().join("\n").as_bytes());
    for file in &normal.files {
        put(&host.read(file, Origin::Options)?);
    }
    for flank in design.measured_flanks() {
        match host.read(&InputFile(flank.file), Origin::Design) {
            // A check says of a file that is not there, or cannot be used, what is wrong with it.
            Err(error) if analysis.name == "check" => put(error.to_string().as_bytes()),
            content => put(&content?),
        }
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
