//! Laws chosen by name and coefficients given in one of several ways.

use super::consistency::{Place, contradiction, needs};
use super::error::Source;
use super::service::{Parameter, PartWearSection, RollingWearSection, WearSection};
use super::{At, CoefficientSection, DesignError, DesignSections, Section};
use crate::machine::*;
use crate::named::LawName;
use crate::tribology::Lubrication;
use crate::units::{ARCMIN, HOUR, MM, MPA, UM};

/// The law chosen by name, with its own parameters only.
pub(super) fn law<N: LawName>(
    name: &At<N>,
    section: &Place,
    parameters: &[Parameter<'_>],
    source: &Source,
) -> Result<N::Law, Box<DesignError>> {
    let place = name.span.clone().or(section.clone());
    let title = |name: N| format!("the {} \"{}\"", N::KIND, name.word());
    for (key, at) in parameters.iter().filter(|(_, at)| at.is_some()) {
        if !name.parameters().contains(key) {
            let owners = N::NAMES.iter().filter(|owner| owner.parameters().contains(key));
            let owners = owners.map(|owner| title(*owner)).collect::<Vec<_>>().join(" and ");
            let message = format!("`{key}` belongs to {owners}, but the law here is \"{}\"", name.word());
            return Err(contradiction(source, &at.span, message, "leave it out or choose its law"));
        }
    }
    let value = |key: &&'static str| {
        let given = parameters.iter().find(|(name, _)| name == key).and_then(|(_, at)| at.value);
        given.ok_or_else(|| needs(source, &place, &title(name.value), key))
    };
    let values = name.parameters().iter().map(value).collect::<Result<Vec<f64>, _>>()?;
    // Every parameter has a value here.
    name.law(&values).ok_or_else(|| needs(source, &place, &title(name.value), "parameters"))
}

/// Wear of flanks, pins, bearings and gears.
pub(super) fn wear(design: &DesignSections, source: &Source) -> Result<Wear, Box<DesignError>> {
    Ok(Wear { parts: part_wear(design, source)?, ..flank_wear(&design.wear, source)? })
}

/// Wear of flanks and pins only.
pub(super) fn flank_wear(wear: &WearSection, source: &Source) -> Result<Wear, Box<DesignError>> {
    let coupled = coefficient(&wear.coupled, &wear.coupled.span, source)?;
    Ok(Wear {
        law: law(&wear.law.name, &wear.law.span, &wear.law.parameters(), source)?,
        coupled,
        paper: match &wear.paper.value {
            Some(paper) => coefficient(paper, &wear.paper.span, source)?,
            None => coupled,
        },
        running_in: wear.running_in.as_ref().map(|running_in| RunningIn {
            factor: *running_in.factor,
            duration: *running_in.duration_h * HOUR,
        }),
        pin_ratio: *wear.pin_ratio,
        lubrication: wear.lubrication.as_ref().map(|film| Lubrication {
            viscosity: *film.viscosity_mpa_s * 1e-3,
            pressure_viscosity: *film.pressure_viscosity_per_gpa * 1e-9,
            roughness: *film.roughness_um * UM,
        }),
        parts: PartWearLaws::default(),
    })
}

/// Wear of flanks, pins and eccentric bearings of drives of eccentrics.
pub(super) fn stage_wear(
    wear: &WearSection,
    eccentrics: &[RollerKind],
    source: &Source,
) -> Result<Wear, Box<DesignError>> {
    let mut parts = PartWearLaws::default();
    for kind in eccentrics {
        parts.turning_arm = rolling(&wear.turning_arm, *kind, source)?;
    }
    Ok(Wear { parts, ..flank_wear(wear, source)? })
}

/// Wear of rolling bearings.
fn rolling(
    at: &At<Option<Section<RollingWearSection>>>,
    kind: RollerKind,
    source: &Source,
) -> Result<Option<RollingWear>, Box<DesignError>> {
    let Some(part) = &at.value else { return Ok(None) };
    if kind == RollerKind::Ball {
        let message =
            "the wear of ball bearings is not modelled: their contacts have no fixed width".to_owned();
        return Err(contradiction(source, &at.span, message, "leave this section out"));
    }
    let keys = [
        &part.coefficient_per_pa,
        &part.coefficient_mm2_per_n,
        &part.archard_coefficient,
        &part.hardness_mpa,
    ];
    Ok(Some(RollingWear { coefficient: part_coefficient(keys, &at.span, source)?, slip: *part.slip }))
}

/// Wear of bearings and gears.
fn part_wear(design: &DesignSections, source: &Source) -> Result<PartWearLaws, Box<DesignError>> {
    let wear = &design.wear;
    let teeth = |at: &At<Option<Section<PartWearSection>>>| -> Result<f64, Box<DesignError>> {
        let Some(part) = &at.value else { return Ok(0.0) };
        let keys = [
            &part.coefficient_per_pa,
            &part.coefficient_mm2_per_n,
            &part.archard_coefficient,
            &part.hardness_mpa,
        ];
        part_coefficient(keys, &at.span, source)
    };
    Ok(PartWearLaws {
        turning_arm: rolling(&wear.turning_arm, *design.bearings.turning_arm.kind, source)?,
        crank_support: rolling(&wear.crank_support, *design.bearings.crank_support.kind, source)?,
        sun: teeth(&wear.sun)?,
        planet: teeth(&wear.planet)?,
    })
}

/// k in 1/Pa from `coefficient_per_pa`, `coefficient_mm2_per_n` or `archard_coefficient` with `hardness_mpa`.
fn part_coefficient(
    keys: [&At<Option<f64>>; 4],
    place: &Place,
    source: &Source,
) -> Result<f64, Box<DesignError>> {
    const FORMS: &str =
        "give exactly one of coefficient_per_pa; coefficient_mm2_per_n; archard_coefficient and hardness_mpa";
    match keys.map(|at| at.value) {
        [Some(k), None, None, None] => Ok(k),
        [None, Some(k), None, None] => Ok(k * MM * MM),
        [None, None, Some(k), Some(hardness)] => Ok(k / (hardness * MPA)),
        [None, None, Some(_), None] => Err(needs(source, place, "`archard_coefficient`", "hardness_mpa")),
        [None, None, None, _] => {
            Err(contradiction(source, place, "the wear coefficient is not given".to_owned(), FORMS))
        }
        _ => Err(contradiction(
            source,
            place,
            "the wear coefficient is given in more than one way".to_owned(),
            FORMS,
        )),
    }
}

/// k from the one form that the section gives.
fn coefficient(
    section: &CoefficientSection,
    place: &Place,
    source: &Source,
) -> Result<WearCoefficient, Box<DesignError>> {
    const FORMS: &str = "give exactly one of coefficient_per_pa; coefficient_mm2_per_n; archard_coefficient and hardness_mpa; \
                        after_h and depth_um; after_h and lost_motion_arcmin";
    let ways = [
        ("coefficient_per_pa", &section.coefficient_per_pa),
        ("coefficient_mm2_per_n", &section.coefficient_mm2_per_n),
        ("archard_coefficient", &section.archard_coefficient),
        ("depth_um", &section.depth_um),
        ("lost_motion_arcmin", &section.lost_motion_arcmin),
    ];
    let given: Vec<_> = ways.iter().filter(|(_, at)| at.is_some()).collect();
    match given[..] {
        [] => {
            return Err(contradiction(source, place, "the wear coefficient is not given".to_owned(), FORMS));
        }
        [_] => {}
        [(first, _), (second, at), ..] => {
            return Err(contradiction(
                source,
                &at.span,
                format!("the wear coefficient is given twice, by `{first}` and by `{second}`"),
                FORMS,
            ));
        }
    }
    for (partner, at, main) in
        [("hardness_mpa", &section.hardness_mpa, &ways[2..3]), ("after_h", &section.after_h, &ways[3..5])]
    {
        let used = main.iter().find(|(_, at)| at.is_some());
        match (at.value, used) {
            (None, Some((key, _))) => return Err(needs(source, place, &format!("`{key}`"), partner)),
            (Some(_), None) => {
                return Err(contradiction(
                    source,
                    &at.span,
                    format!("`{partner}` is given without the coefficient that needs it"),
                    FORMS,
                ));
            }
            _ => {}
        }
    }
    let hardness = section.hardness_mpa.unwrap_or(1.0) * MPA;
    let time = section.after_h.unwrap_or(0.0) * HOUR;
    Ok(
        match (
            *section.coefficient_per_pa,
            *section.coefficient_mm2_per_n,
            *section.archard_coefficient,
            *section.depth_um,
        ) {
            (Some(k), ..) => WearCoefficient::Given(k),
            (_, Some(k), ..) => WearCoefficient::Given(k * MM * MM),
            (_, _, Some(k), _) => WearCoefficient::Given(k / hardness),
            (.., Some(depth)) => WearCoefficient::Calibrated { time, depth: depth * UM },
            _ => WearCoefficient::CalibratedLostMotion {
                time,
                increase: section.lost_motion_arcmin.unwrap_or(0.0) * ARCMIN,
            },
        },
    )
}
