use super::{Finding, Severity, severity_if};
use crate::machine::{DutyPoint, Machine, WearCoefficient};

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    vec![overload(machine), coefficient(machine)]
}

fn overload(machine: &Machine) -> Finding {
    let largest = DutyPoint::largest_torque(&machine.duty);
    let limit = 2.5 * machine.rated.torque;
    Finding {
        code: "duty-torque",
        severity: severity_if(largest > limit, Severity::Warning),
        message: format!(
            "the largest torque of the duty is {largest} N·m, the rated torque {} N·m",
            machine.rated.torque
        ),
        value: largest,
        limit,
        unit: "N·m",
        why: "makers of RV reducers allow 2.5 times the rated torque when accelerating and stopping",
        change: "a larger reducer or a gentler duty",
    }
}

fn coefficient(machine: &Machine) -> Finding {
    // Steel on steel in oil: 1e-20 (full film) to 1e-16 1/Pa (poor lubrication).
    let (low, high) = (1e-21, 1e-15);
    let (severity, message, value) = match machine.wear.coupled {
        WearCoefficient::Given(k) => (
            severity_if(!(low..=high).contains(&k), Severity::Warning),
            format!("the wear coefficient is {k:.3e} 1/Pa"),
            k,
        ),
        _ => (Severity::Info, "the wear coefficient is calibrated from an observation".to_owned(), 0.0),
    };
    Finding {
        code: "wear-coefficient",
        severity,
        message,
        value,
        limit: high,
        unit: "1/Pa",
        why: "lubricated hardened steel lies between 1e-21 and 1e-15 1/Pa; a coefficient outside has most likely another unit",
        change: "check the unit: 1 mm²/N is 1e-6 1/Pa",
    }
}
