//! A single stage from ratio, torque and outer diameter: sizes by rules, widths by static equilibria.

mod demand;
mod elastic;
mod file;
mod gaps;
mod process;
mod sizes;

pub use demand::{Demand, DemandError, Shortfall};
pub use gaps::Gaps;
pub use process::Process;
pub use sizes::Proposal;

use super::stage::{DRIVES, EccentricDrive};
use super::{AnalysisError, Host, NoHost};
use crate::checks::Severity;
use crate::design::{Choice, StageDesign};
use crate::fidelity::DiscBodies;
use crate::units::{MM, MPA};
use elastic::Loads;
use gaps::{JAM_LIMIT, Series};
use process::Makes;
use sizes::{BENDING, half_mm, pin_bending};

/// A proposed drive.
#[derive(Debug, Clone)]
pub struct Proposed {
    /// Design file of the drive.
    pub text: String,
    /// Sentences, also in the head of the text: the check nearest to its limit, and the torque that the size reaches.
    pub notes: Vec<String>,
}

/// Positions over a turn of the input, as `check` takes.
const POSITIONS: usize = 24;
/// Number of combinations whose equilibria are computed.
const TRIED: usize = 6;
/// Bisections of the torque or diameter at which the rules end.
const HALVINGS: usize = 5;
/// Largest number of doublings of a torque, and of steps of a quarter of a diameter.
const DOUBLINGS: usize = 12;
const LARGEST_DIAMETER_MM: f64 = 400.0;

/// Rounds in which gaps are enlarged and sizes selected again.
const ROUNDS: usize = 6;

/// A proposal with the width of its discs and its checks.
#[derive(Clone)]
struct Fitted {
    proposal: Proposal,
    width_mm: f64,
    checks: Vec<Check>,
    /// Share of the drawn drives that jam, if counted.
    jam_rate: Option<f64>,
}

/// A value over its limit, with a sentence.
#[derive(Clone)]
struct Check {
    share: f64,
    words: String,
}

/// Proposes a single stage.
///
/// # Errors
/// [`AnalysisError`]: an invalid demand, a demand that no drive within the rules meets (with the failing check and
/// remedies), equilibria that are not found.
pub fn propose(demand: Demand, host: &dyn Host) -> Result<Proposed, AnalysisError> {
    demand.check().map_err(|error| {
        let help = match error {
            DemandError::Fraction { tooth_difference, .. } => {
                let lobes = (tooth_difference as f64 * demand.ratio).floor();
                let ratio = |lobes: f64| lobes / tooth_difference as f64;
                format!("{} or {} does", ratio(lobes), ratio(lobes + 1.0))
            }
            DemandError::Range(_) => "correct the value; two stages give larger ratios".to_owned(),
        };
        AnalysisError::usage(error.to_string(), help)
    })?;
    let fitted = match fit(&demand, host)? {
        Ok(fitted) => fitted,
        Err(shortfall) => return Err(refused(&demand, &shortfall, host)?),
    };
    host.report("elastic discs", 0.0);
    let (fitted, with_elastic_discs) = elastic::judged(fitted, host)?;
    let mut notes = Vec::new();
    if let Some(nearest) = fitted.checks.iter().max_by(|a, b| a.share.total_cmp(&b.share)) {
        let how = if nearest.share > 1.0 { "Over its limit, a warning" } else { "Nearest to its limit" };
        notes.push(format!("{how}: {}.", nearest.words));
    }
    notes.push(with_elastic_discs);
    let Gaps { profile_um, hole_um } = fitted.proposal.gaps;
    notes.extend(fitted.jam_rate.map(|jam_rate| {
        format!(
            "{:.1} % of {DRIVES} drives drawn from the tolerances jam, at most {:.0} % by the rule: with a gap of the flank of {profile_um} \
             µm and a clearance of the holes of {hole_um} µm.",
            100.0 * jam_rate,
            100.0 * JAM_LIMIT
        )
    }));
    notes.push(reach(&demand, fitted.proposal.gaps, host)?);
    Ok(Proposed { text: fitted.proposal.text(fitted.width_mm, &notes), notes })
}

/// The first proposal that keeps all limits, with gaps with which few drawn drives jam; or the shortfall of the
/// nearest one.
fn fit(demand: &Demand, host: &dyn Host) -> Result<Result<Fitted, Shortfall>, AnalysisError> {
    let least = demand.process.making().gaps;
    let (mut gaps, mut jam_rate) = (least, 0.0);
    for _ in 0..ROUNDS {
        let fitted = match fit_with(demand, gaps, host)? {
            Ok(fitted) => fitted,
            Err(shortfall) => return Ok(Err(shortfall)),
        };
        let design = StageDesign::parse(&fitted.proposal.text(fitted.width_mm, &[]), "the proposed design")?;
        let Some(series) = Series::of(&design) else { return Ok(Ok(fitted)) };
        jam_rate = series.jam_rate();
        if series.keeps_the_limit() {
            return Ok(Ok(Fitted { jam_rate: Some(jam_rate), ..fitted }));
        }
        match series.enough(gaps, least) {
            Some(enough) => gaps = enough,
            None => break,
        }
    }
    let message = format!(
        "jam-rate: {:.1} % of the drawn drives go together by force only, with a gap of {} µm and a clearance of {} µm",
        100.0 * jam_rate,
        gaps.profile_um,
        gaps.hole_um
    );
    Ok(Err(Shortfall { message, excess: jam_rate / JAM_LIMIT, is_bending: false }))
}

/// The same with given gaps, without counting jammed drives.
fn fit_with(
    demand: &Demand,
    gaps: Gaps,
    host: &dyn Host,
) -> Result<Result<Fitted, Shortfall>, AnalysisError> {
    let proposals = match demand.proposals(gaps) {
        Ok(proposals) => proposals,
        Err(shortfall) => return Ok(Err(shortfall)),
    };
    let mut nearest: Option<Shortfall> = None;
    // Output pins with the same bending as those that failed would fail as well.
    let mut bending = f64::INFINITY;
    let mut tried = 0;
    for proposal in proposals {
        if proposal.bending >= bending {
            continue;
        }
        let even = proposal.bending;
        match widened(proposal, host)? {
            Ok(fitted) => return Ok(Ok(fitted)),
            Err(shortfall) => {
                if shortfall.is_bending {
                    bending = bending.min(even / shortfall.excess);
                }
                if nearest.as_ref().is_none_or(|held| shortfall.excess < held.excess) {
                    nearest = Some(shortfall);
                }
            }
        }
        tried += 1;
        if tried == TRIED {
            break;
        }
    }
    Ok(Err(nearest.unwrap_or_else(Shortfall::none)))
}

/// Widens the discs, from the width by closed forms, until the pressure of flanks and holes in equilibria with all
/// gaps is permitted.
fn widened(proposal: Proposal, host: &dyn Host) -> Result<Result<Fitted, Shortfall>, AnalysisError> {
    let widest = proposal.widest_mm();
    let limit = proposal.pressure();
    let mut width_mm = half_mm(proposal.width_mm);
    let mut cause = "contact-pressure by the closed forms, or the eccentric bearing".to_owned();
    loop {
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        if width_mm > widest {
            let message = format!(
                "{cause}; discs of {width_mm} mm are needed, the widest are {widest} mm, {} of the outer diameter",
                proposal.widest_share()
            );
            return Ok(Err(Shortfall { message, excess: width_mm / widest, is_bending: false }));
        }
        let design = StageDesign::parse(&proposal.text(width_mm, &[]), "the proposed design")?;
        let loads = Loads::of(&design, DiscBodies::Rigid, &NoHost)?;
        let Loads { flank, hole, output_pin_force: force } = loads;
        let share = loads.pressure() / limit;
        if share > 1.0 {
            let what = if flank > hole { "ring pins on flanks" } else { "output pins in holes" };
            cause = format!(
                "contact-pressure: {what} press with {:.0} MPa of {:.0} MPa on discs of {width_mm} mm",
                loads.pressure() / MPA,
                limit / MPA
            );
            // p² is proportional to 1/B if the forces do not change.
            width_mm = half_mm(width_mm * share * share).max(width_mm + 0.5);
            continue;
        }
        let bending = pin_bending(force, width_mm * MM, proposal.output_pin());
        if bending > BENDING {
            let message =
                format!("bending of the output pins: {:.0} MPa of {:.0} MPa", bending / MPA, BENDING / MPA);
            return Ok(Err(Shortfall { message, excess: bending / BENDING, is_bending: true }));
        }
        let all = design.findings();
        if let Some(wrong) = all.iter().find(|finding| finding.severity == Severity::Error) {
            let message = format!("{}: {}", wrong.code, wrong.message);
            return Ok(Err(Shortfall { message, excess: wrong.value / wrong.limit, is_bending: false }));
        }
        let mpa = |what: &str, found: f64, limit: f64| Check {
            share: found / limit,
            words: format!("{what} {:.0} MPa of {:.0} MPa", found / MPA, limit / MPA),
        };
        let mut checks = vec![
            mpa(&format!("pressure of ring pins on discs of {width_mm} mm,"), flank, limit),
            mpa(&format!("pressure of output pins in holes of discs of {width_mm} mm,"), hole, limit),
            mpa("bending of the output pins,", bending, BENDING),
        ];
        checks.extend(all.iter().find(|finding| finding.code == "eccentric-bearing-life").map(|life| {
            let words =
                format!("life of the eccentric bearing, {:.0} h of {:.0} h planned", life.value, life.limit);
            Check { share: life.limit / life.value, words }
        }));
        return Ok(Ok(Fitted { proposal, width_mm, checks, jam_rate: None }));
    }
}

/// Two values between which the rules end, by bisection: the last valid one, and the first invalid one with its
/// shortfall.
fn between(
    mut does: f64,
    mut fails: (f64, Shortfall),
    fits: impl Fn(f64) -> Result<Result<Fitted, Shortfall>, AnalysisError>,
) -> Result<(f64, Shortfall), AnalysisError> {
    for _ in 0..HALVINGS {
        let middle = (does * fails.0).sqrt();
        match fits(middle)? {
            Ok(_) => does = middle,
            Err(shortfall) => fails = (middle, shortfall),
        }
    }
    Ok((does, fails.1))
}

/// Largest torque within the rules at this size, and the check that fails beyond, with these gaps.
fn reach(demand: &Demand, gaps: Gaps, host: &dyn Host) -> Result<String, AnalysisError> {
    let fits = |torque: f64| fit_with(&Demand { torque, ..*demand }, gaps, host);
    let mut does = demand.torque;
    for doubling in 0..DOUBLINGS {
        host.report("torque that this size reaches", doubling as f64 / DOUBLINGS as f64);
        match fits(2.0 * does)? {
            Ok(_) => does *= 2.0,
            Err(shortfall) => {
                let (most, shortfall) = between(does, (2.0 * does, shortfall), fits)?;
                return Ok(format!(
                    "In {} mm the rules reach about {} N·m with rigid discs; beyond that, {}.",
                    demand.outer_diameter_mm,
                    rounded_torque(demand, most, host)?,
                    shortfall.message
                ));
            }
        }
    }
    Ok(format!(
        "In {} mm the rules reach more than {} N·m with rigid discs.",
        demand.outer_diameter_mm,
        digits(does)
    ))
}

/// Rounded down to two digits.
fn digits(value: f64) -> f64 {
    let unit = 10_f64.powi(value.log10().floor() as i32 - 1);
    let floor = (value / unit * (1.0 + 1e-9)).floor() * unit;
    format!("{floor:.3e}").parse().unwrap_or(floor)
}

/// A torque rounded to two digits for which a drive exists: because of the steps of standard sizes a smaller torque
/// may have none while a larger one has.
fn rounded_torque(demand: &Demand, most: f64, host: &dyn Host) -> Result<f64, AnalysisError> {
    let mut torque = digits(most);
    for _ in 0..HALVINGS {
        if fit(&Demand { torque, ..*demand }, host)?.is_ok() {
            break;
        }
        torque = digits(0.97 * torque);
    }
    Ok(torque)
}

/// The error for a demand that no drive meets: the failing check, and changes that would help.
fn refused(demand: &Demand, shortfall: &Shortfall, host: &dyn Host) -> Result<AnalysisError, AnalysisError> {
    let mut remedies = Vec::new();
    let wider = |diameter: f64| Demand { outer_diameter_mm: diameter, ..*demand };
    let mut diameter = demand.outer_diameter_mm;
    while diameter < LARGEST_DIAMETER_MM {
        let next = (1.25 * diameter).min(LARGEST_DIAMETER_MM);
        if fit(&wider(next), host)?.is_ok() {
            // From below: `between` proceeds from valid to invalid values.
            let fails = (diameter, shortfall.clone());
            let mut least = between(next, fails, |diameter| fit(&wider(diameter), host))?.0.ceil();
            // A diameter can be rounded up, except at a step of standard sizes.
            while fit(&wider(least), host)?.is_err() && least < next {
                least += 1.0;
            }
            remedies.push(format!("an outer diameter of {} mm", least.min(next)));
            break;
        }
        diameter = next;
    }
    let lighter = |torque: f64| Demand { torque, ..*demand };
    let mut torque = demand.torque;
    for _ in 0..DOUBLINGS {
        let next = 0.5 * torque;
        if fit(&lighter(next), host)?.is_ok() {
            let fails = (torque, shortfall.clone());
            let most = between(next, fails, |torque| fit(&lighter(torque), host))?.0;
            remedies.push(format!("{} N·m", rounded_torque(demand, most, host)?));
            break;
        }
        torque = next;
    }
    for process in Process::VALUES.iter().filter(|process| **process != demand.process) {
        if fit(&Demand { process: *process, ..*demand }, host)?.is_ok() {
            remedies.push(format!("--process {}", process.word()));
        }
    }
    let other = Demand { tooth_difference: 3 - demand.tooth_difference, ..*demand };
    if other.check().is_ok() && fit(&other, host)?.is_ok() {
        remedies.push(format!("--tooth-difference {}", other.tooth_difference));
    }
    let help = match remedies.as_slice() {
        [] => {
            "neither a larger outer diameter, nor less torque, nor another process or tooth difference alone suffices".to_owned()
        }
        [one] => format!("{one} does"),
        all => format!("one of these does: {}", all.join(", ")),
    };
    let message = format!(
        "no single stage of {} : 1{} and {} mm, {}, carries {} N·m: {}",
        demand.ratio,
        if demand.tooth_difference == 1 { "" } else { " with a tooth difference of 2" },
        demand.outer_diameter_mm,
        demand.process.word(),
        demand.torque,
        shortfall.message
    );
    Ok(AnalysisError::usage(message, help))
}

#[cfg(test)]
mod tests;
