/// Why a study cannot be set up or evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StudyError {
    #[error("a distribution cannot be drawn from: {reason}")]
    Distribution { reason: &'static str },
    #[error("these samples cannot be laid out: {reason}")]
    Sampling { reason: String },
    #[error("the statistic cannot be computed: {reason}")]
    Statistic { reason: &'static str },
    #[error("the search cannot go on: {reason}")]
    Search { reason: String },
}
