/// Generalised-α coefficients (Chung & Hulbert 1993) for a given ρ∞, in the form of Arnold & Brüls 2007:
/// (1−α_m) a_{n+1} + α_m a_n = (1−α_f) q̈_{n+1} + α_f q̈_n, with M q̈ = Q at the nodes and Newmark's formulas
/// for q and q̇.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coefficients {
    pub alpha_m: f64,
    pub alpha_f: f64,
    pub beta: f64,
    pub gamma: f64,
    /// Local error of the position divided by h³ q⃛ and of the velocity divided by h³ d⁴q/dt⁴.
    pub position_error: f64,
    pub velocity_error: f64,
}

impl Coefficients {
    pub fn new(rho: f64) -> Coefficients {
        let alpha_m = (2.0 * rho - 1.0) / (rho + 1.0);
        let alpha_f = rho / (rho + 1.0);
        let gamma = 0.5 + alpha_f - alpha_m;
        let beta = 0.25 * (gamma + 0.5).powi(2);
        // a_n approximates q̈ at t_n + δ h, with an error ε h² of second order in q̈.
        let delta = alpha_m - alpha_f;
        let epsilon =
            0.5 * (1.0 - alpha_f) - 0.5 * ((1.0 - alpha_m) * (1.0 + delta).powi(2) + alpha_m * delta * delta);
        Coefficients {
            alpha_m,
            alpha_f,
            beta,
            gamma,
            position_error: (1.0 / 6.0 - 0.5 * delta - beta).abs(),
            velocity_error: (1.0 / 6.0
                - 0.5 * ((1.0 - gamma) * delta * delta + gamma * (1.0 + delta).powi(2))
                - epsilon)
                .abs(),
        }
    }
}
