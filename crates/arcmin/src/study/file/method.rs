use crate::design::Choice;

/// Ways of choosing machines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MethodName {
    /// Every combination of levels.
    Grid,
    /// Samples independent of each other.
    Random,
    /// One sample in each equal part of every range.
    LatinHypercube,
    /// A scrambled Sobol sequence.
    Sobol,
    /// Trajectories of elementary effects (Morris).
    Morris,
    /// Samples for first and total shares of the variance (Saltelli).
    Saltelli,
    /// Each machine again with one tolerance tightened.
    Tighten,
    /// Entry by entry of all lists together.
    Cases,
    /// Search by CMA-ES or NSGA-II.
    Optimise,
}

impl Choice for MethodName {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("grid", "every combination of levels"),
        ("random", "independent of each other"),
        ("latin-hypercube", "one in each equal part of every range"),
        ("sobol", "a scrambled Sobol sequence: most even, best with a power of two"),
        ("morris", "trajectories of elementary effects: keys with a large effect"),
        ("saltelli", "first and total shares of the variance (Sobol indices)"),
        ("tighten", "each machine again with one tolerance tightened: the tolerance to tighten first"),
        ("cases", "entry by entry of all lists together"),
        ("optimise", "search for the best design, by one goal (CMA-ES) or two (NSGA-II)"),
    ];
    const VALUES: &'static [MethodName] = &[
        MethodName::Grid,
        MethodName::Random,
        MethodName::LatinHypercube,
        MethodName::Sobol,
        MethodName::Morris,
        MethodName::Saltelli,
        MethodName::Tighten,
        MethodName::Cases,
        MethodName::Optimise,
    ];
}

/// Direction of a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// The smaller the better.
    Smallest,
    /// The larger the better.
    Largest,
}

impl Choice for Aim {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("smallest", "the smaller the better"), ("largest", "the larger the better")];
    const VALUES: &'static [Aim] = &[Aim::Smallest, Aim::Largest];
}
