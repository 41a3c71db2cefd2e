use super::error::shown;

/// Names given by the user for columns with unknown names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Naming {
    /// Name or number in the file, and its meaning; `None` skips the column.
    pub(super) pairs: Vec<(String, Option<String>)>,
    /// Lines skipped at the beginning of the file.
    pub(super) skip_lines: usize,
}

impl Naming {
    /// From `J3_ActTorque=torque_n_m,J3_ActVelo=speed_rpm`; a number such as in `3=speed_rpm` counts columns
    /// from 1, and `-` skips a column.
    ///
    /// # Errors
    /// Text of another form, with a message.
    pub fn parse(text: &str) -> Result<Naming, String> {
        let mut pairs = Vec::new();
        for part in text.split(',').filter(|part| !part.trim().is_empty()) {
            // Names in files may contain the equals sign, ours do not.
            let Some((theirs, ours)) = part.rsplit_once('=') else {
                return Err(format!("\"{}\" is not of the form name=column", shown(part.trim())));
            };
            let (theirs, ours) = (theirs.trim().to_owned(), ours.trim().to_owned());
            if theirs.is_empty() || ours.is_empty() {
                return Err(format!("\"{}\" lacks a name", shown(part.trim())));
            }
            pairs.push((theirs, (ours != "-").then_some(ours)));
        }
        Ok(Naming { pairs, skip_lines: 0 })
    }

    /// The same, with lines skipped at the beginning of the file.
    pub fn skipping(self, lines: usize) -> Naming {
        Naming { skip_lines: lines, ..self }
    }
}
