/// Error of a study that cannot be set up or evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// Parameters of a distribution contradict each other.
    #[error("a distribution cannot be drawn from: {reason}")]
    Distribution {
        /// Violated condition as named in the message.
        reason: &'static str,
    },
    /// A layout is not possible for the number of samples or dimensions.
    #[error("these samples cannot be laid out: {reason}")]
    Sampling {
        /// Violated condition as named in the message.
        reason: String,
    },
    /// The values are not sufficient for the statistic.
    #[error("the statistic cannot be computed: {reason}")]
    Statistic {
        /// Violated condition as named in the message.
        reason: &'static str,
    },
    /// The settings of a search, or the results of a generation, are not valid.
    #[error("the search cannot go on: {reason}")]
    Search {
        /// Violated condition as named in the message.
        reason: String,
    },
}
