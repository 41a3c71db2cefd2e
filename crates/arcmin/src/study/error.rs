/// Error of a study that cannot be set up or evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// Parameters of a distribution contradict each other.
    #[error("a distribution cannot be drawn from: {reason}")]
    Distribution {
        /// Condition that is broken, as words of the message.
        reason: &'static str,
    },
    /// A layout cannot hold the samples or dimensions asked for.
    #[error("these samples cannot be laid out: {reason}")]
    Sampling {
        /// Condition that is broken, as words of the message.
        reason: String,
    },
    /// Values do not determine the figure asked for.
    #[error("the statistic cannot be computed: {reason}")]
    Statistic {
        /// Condition that is broken, as words of the message.
        reason: &'static str,
    },
    /// The settings of a search, or results of a generation, do not fit.
    #[error("the search cannot go on: {reason}")]
    Search {
        /// Condition that is broken, as words of the message.
        reason: String,
    },
}
