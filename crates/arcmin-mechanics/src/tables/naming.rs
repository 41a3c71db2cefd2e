use super::error::shown;

/// Names given by the user for the columns of a file whose names this program does not know.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Naming {
    /// Name or number in the file, and the name that it stands for; `None` passes the column over.
    pub(super) pairs: Vec<(String, Option<String>)>,
    /// Lines passed over at the beginning of the file.
    pub(super) skip_lines: usize,
}

impl Naming {
    /// Of `J3_ActTorque=torque_n_m,J3_ActVelo=speed_rpm`, where a number such as `3=speed_rpm` counts columns
    /// from 1 and `-` passes a column over.
    ///
    /// # Errors
    /// Refuses text that cannot be understood, with a sentence.
    pub fn parse(text: &str) -> Result<Naming, String> {
        let mut pairs = Vec::new();
        for part in text.split(',').filter(|part| !part.trim().is_empty()) {
            // Names in files may contain the sign, ours do not.
            let Some((theirs, ours)) = part.rsplit_once('=') else {
                return Err(format!("\"{}\" does not say which column is which", shown(part.trim())));
            };
            let (theirs, ours) = (theirs.trim().to_owned(), ours.trim().to_owned());
            if theirs.is_empty() || ours.is_empty() {
                return Err(format!("\"{}\" lacks a name", shown(part.trim())));
            }
            pairs.push((theirs, (ours != "-").then_some(ours)));
        }
        Ok(Naming { pairs, skip_lines: 0 })
    }

    /// The same, with lines passed over at the beginning of the file.
    pub fn skipping(self, lines: usize) -> Naming {
        Naming { skip_lines: lines, ..self }
    }
}
