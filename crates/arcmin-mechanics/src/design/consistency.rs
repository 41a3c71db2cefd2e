//! Values that are valid one by one but contradict each other. No machine can be built from them, so they are
//! errors, not findings.

use std::ops::Range;

use super::error::{DesignErrorKind, Source};
use super::hint::plain;
use super::{
    At, DesignError, DesignSections, DiscSection, DutySection, LoadSection, ModificationSection, RingSection,
    RollerBearingSection, Section, resolve,
};
use crate::geometry::{Profile, TipError, unit};
use crate::machine::{Bore, PinMounting, roller_spacing};
use crate::units::MM;

/// Bytes in the file, if the value is in the file.
pub(super) type Place = Option<Range<usize>>;
type Result<T> = std::result::Result<T, Box<DesignError>>;

pub(super) fn contradiction(source: &Source, place: &Place, message: String, hint: &str) -> Box<DesignError> {
    source.error(
        DesignErrorKind::Contradiction { message },
        place.clone().unwrap_or(0..0),
        Some(hint.to_owned()),
    )
}

pub(super) fn needs(source: &Source, place: &Place, what: &str, key: &str) -> Box<DesignError> {
    contradiction(source, place, format!("{what} needs `{key}`"), &format!("add `{key} = …` beside it"))
}

pub(super) fn check(design: &DesignSections, source: &Source) -> Result<()> {
    teeth_of_rv(&design.ring, &design.disc, source)?;
    separate_pins(&design.ring, source)?;
    gear_stage(design, source)?;
    let eccentricity = &design.crankshafts.eccentricity_mm.span;
    flank(&resolve::profile(design), &design.ring, &design.disc.modification, eccentricity, source)?;
    bores(&resolve::profile(design), &resolve::bores(design), source)?;
    super::bodies::check(design, source)?;
    free_form(&design.disc.modification, source)?;
    roller_bearing("turning_arm", &design.bearings.turning_arm, source)?;
    roller_bearing("crank_support", &design.bearings.crank_support, source)?;
    preload(design, source)?;
    duty(&design.duty, &design.load, source)
}

/// RV reducers have a tooth difference of 1 and complete lobes, without a tip diameter.
fn teeth_of_rv(ring: &RingSection, disc: &DiscSection, source: &Source) -> Result<()> {
    for (key, place) in
        [("tooth_difference", &ring.tooth_difference.span), ("tip_diameter_mm", &disc.tip_diameter_mm.span)]
    {
        if place.is_some() {
            let message =
                format!("`{key}` describes drives of eccentrics; RV reducers have one lobe less than pins");
            let hint = "leave it out, or choose another family of drives in [drive]";
            return Err(contradiction(source, place, message, hint));
        }
    }
    lobes_or(ring, &disc.lobe_count, source, false)
}

/// RV reducers have pins in seats of the housing.
fn separate_pins(ring: &RingSection, source: &Source) -> Result<()> {
    if *ring.pin_mounting != PinMounting::OnePiece {
        return Ok(());
    }
    let message = "the pins of an RV reducer lie in seats of its housing".to_owned();
    Err(contradiction(source, &ring.pin_mounting.span, message, "choose \"fixed\" or \"spinning\""))
}

/// Whether the number of lobes fits the ring of a drive of eccentrics, if the file gives it.
pub(super) fn lobes(ring: &RingSection, lobe_count: &At<Option<usize>>, source: &Source) -> Result<()> {
    lobes_or(ring, lobe_count, source, true)
}

/// The same, with another tooth difference in the hint if the ring allows one.
fn lobes_or(
    ring: &RingSection,
    lobe_count: &At<Option<usize>>,
    source: &Source,
    differs: bool,
) -> Result<()> {
    let (pins, difference) = (*ring.pin_count, ring.tooth_difference.unwrap_or(1));
    // A disc needs at least three lobes.
    if pins < difference + 3 {
        let message = format!(
            "{pins} pins with a tooth difference of {difference} leave a disc of {} lobes",
            pins - difference
        );
        return Err(contradiction(
            source,
            &ring.pin_count.span,
            message,
            "a disc needs three lobes at least",
        ));
    }
    match lobe_count.value {
        Some(lobes) if lobes + difference != pins => {
            let less = match difference {
                1 => "one lobe less than the ring has pins".to_owned(),
                _ => format!(
                    "{difference} lobes less than the ring has pins (tooth_difference = {difference})"
                ),
            };
            let message = format!("{lobes} lobes do not run in {pins} pins: the disc has {less}");
            // The other tooth difference may be intended.
            let other = match pins - lobes.min(pins) {
                1 | 2 if differs => format!(", or give the ring tooth_difference = {}", pins - lobes),
                _ => String::new(),
            };
            let hint = format!("write lobe_count = {}, or leave it out{other}", pins - difference);
            Err(contradiction(source, &lobe_count.span, message, &hint))
        }
        _ => Ok(()),
    }
}

/// The flank with its tip.
pub(super) fn tip(profile: Profile, diameter: &At<Option<f64>>, source: &Source) -> Result<Profile> {
    let difference = profile.tooth_difference;
    let radius = diameter.map(|diameter| 0.5 * diameter * MM);
    profile.with_teeth(difference, radius).map_err(|error| {
        let (message, hint) = match error {
            TipError::Beyond { meeting } => (
                format!(
                    "the tips end below a diameter of {} mm, {}",
                    plain(2.0 * meeting / MM),
                    match difference {
                        1 => "which whole lobes have",
                        _ => "where the flanks of a lobe meet",
                    }
                ),
                "choose a smaller tip_diameter_mm, or leave it out",
            ),
            TipError::BelowRoot { root } => (
                format!(
                    "the tips must leave a flank: the roots of the disc have a diameter of {} mm",
                    plain(2.0 * root / MM)
                ),
                "choose a larger tip_diameter_mm, or leave it out",
            ),
        };
        contradiction(source, &diameter.span, message, hint)
    })
}

fn gear_stage(design: &DesignSections, source: &Source) -> Result<()> {
    let gear = &design.gear_stage;
    let (sun, planet) = (*gear.sun_teeth as f64, *gear.planet_teeth as f64);
    let ratio = 1.0 + *design.ring.pin_count as f64 * planet / sun;
    // Ratios are often written with few digits: a deviation below 1/2000 is rounding.
    if let Some(given) = gear.ratio.value
        && (given / ratio - 1.0).abs() > 5e-4
    {
        let message = format!(
            "a ratio of {given} contradicts the teeth, which give 1 + z_p z_2/z_1 = {}",
            plain(ratio)
        );
        return Err(contradiction(
            source,
            &gear.ratio.span,
            message,
            "correct pin_count, planet_teeth or sun_teeth, or leave the ratio out",
        ));
    }
    let centre_distance = 0.5 * *gear.module_mm * (sun + planet);
    let circle = &design.crankshafts.circle_radius_mm;
    if let Some(given) = circle.value
        && (given / centre_distance - 1.0).abs() > 5e-4
    {
        let message = format!(
            "crankshafts on a radius of {given} mm do not mesh: the gear stage's centre distance is m (z_1 + z_2)/2 = {} mm",
            plain(centre_distance)
        );
        return Err(contradiction(
            source,
            &circle.span,
            message,
            "correct the module or the teeth, or leave the radius out",
        ));
    }
    Ok(())
}

/// Whether the flank as ground exists; `eccentricity` is the place of that key.
pub(super) fn flank(
    profile: &Profile,
    ring: &RingSection,
    modification: &ModificationSection,
    eccentricity: &Place,
    source: &Source,
) -> Result<()> {
    if *ring.pin_radius_mm >= *ring.pin_circle_radius_mm {
        let message = format!(
            "a pin radius of {} mm does not fit on a pin circle of {} mm",
            *ring.pin_radius_mm, *ring.pin_circle_radius_mm
        );
        return Err(contradiction(
            source,
            &ring.pin_radius_mm.span,
            message,
            "both are radii, not diameters",
        ));
    }
    if profile.pin_radius <= 0.0 {
        let offset = &modification.equidistant_offset_um;
        let message = format!("an equidistant offset of {} µm leaves no generating pin", **offset);
        return Err(contradiction(source, &offset.span, message, "a positive offset opens the gap"));
    }
    let k1 = profile.short_width_coefficient();
    if k1 >= 1.0 {
        let message = format!(
            "the short width coefficient K1 = {} = {} is not below 1: the flank would loop",
            if profile.tooth_difference == 1 { "a z_p/R_p" } else { "a z_p/(m R_p)" },
            plain(k1)
        );
        let hint = format!(
            "with {} pins on {} mm the eccentricity must stay below {} mm",
            profile.pin_count,
            *ring.pin_circle_radius_mm,
            { plain(profile.pin_circle_radius / profile.pins_per_turn() / MM) }
        );
        return Err(contradiction(source, eccentricity, message, &hint));
    }
    let root = profile.root_radius();
    if root <= 0.0 {
        let message =
            "pin radius and eccentricity together exceed the pin circle: no disc is left".to_owned();
        return Err(contradiction(
            source,
            &ring.pin_radius_mm.span,
            message,
            "pin_radius_mm and eccentricity_mm are radii, not diameters",
        ));
    }
    Ok(())
}

/// Whether the bores of a disc, each with its name and place in the file, are clear of its flank and of each
/// other.
pub(super) fn bores(profile: &Profile, all: &[(String, Bore, Place)], source: &Source) -> Result<()> {
    let root = profile.root_radius();
    for (index, (name, bore, place)) in all.iter().enumerate() {
        let outside = bore.centre_radius + bore.radius - root;
        if outside >= 0.0 {
            let message = format!(
                "{name} breaks through the flank: it reaches {} mm, the roots lie at {} mm",
                { plain((bore.centre_radius + bore.radius) / MM) },
                plain(root / MM)
            );
            return Err(contradiction(
                source,
                place,
                message,
                "make it smaller or move it inwards (keys are diameters)",
            ));
        }
        for (other_name, other, _) in &all[..index] {
            let distance = (bore.centre_radius * unit(bore.centre_angle)
                - other.centre_radius * unit(other.centre_angle))
            .norm();
            if distance <= bore.radius + other.radius {
                let message = format!(
                    "{other_name} and {name} overlap: their centres are {} mm apart, their radii add up to {} mm",
                    { plain(distance / MM) },
                    plain((bore.radius + other.radius) / MM)
                );
                return Err(contradiction(
                    source,
                    place,
                    message,
                    "make one smaller or move it (keys are diameters)",
                ));
            }
        }
    }
    Ok(())
}

pub(super) fn free_form(modification: &ModificationSection, source: &Source) -> Result<()> {
    let points = &modification.free_form_deg_um;
    if !points.is_empty() && points.len() < 4 {
        let message = format!("a free form of {} points is not a curve", points.len());
        return Err(contradiction(
            source,
            &points.span,
            message,
            "give at least four points between −180 and 180 degrees",
        ));
    }
    if let Some([angle, _]) = points.iter().find(|[angle, _]| !(-180.0..=180.0).contains(angle)) {
        let message = format!("a meshing angle of {angle}° is outside of −180 to 180");
        return Err(contradiction(
            source,
            &points.span,
            message,
            "both flanks lie between −180 and 180 degrees, the root at 0",
        ));
    }
    if let Some(pair) = points.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
        let message = format!(
            "the meshing angles of the free form must rise, but {}° follows {}°",
            pair[1][0], pair[0][0]
        );
        return Err(contradiction(
            source,
            &points.span,
            message,
            "sort the points by their angle and drop doubles",
        ));
    }
    if let ([first, .., last], true) = (&points[..], points.len() > 1)
        && last[0] - first[0] >= 360.0
        && last[1] != first[1]
    {
        let message = "the free form gives two depths to the tip, at −180° and at 180°".to_owned();
        return Err(contradiction(source, &points.span, message, "give the tip once"));
    }
    Ok(())
}

/// An axial preload needs bearings with a contact angle.
fn preload(design: &DesignSections, source: &Source) -> Result<()> {
    let given = &design.friction.crank_support_preload_n;
    if **given > 0.0 && *design.bearings.crank_support.contact_angle_deg == 0.0 {
        let message = format!("a preload of {} N needs crank supports with a contact angle", **given);
        return Err(contradiction(
            source,
            &given.span,
            message,
            "give bearings.crank_support.contact_angle_deg, or leave crank_support_preload_n out",
        ));
    }
    Ok(())
}

/// A bearing of `[bearings]` by its name there.
pub(super) fn roller_bearing(name: &str, bearing: &RollerBearingSection, source: &Source) -> Result<()> {
    let place = &bearing.roller_count.span;
    match (*bearing.kind == crate::machine::RollerKind::Ball, bearing.roller_length_mm.value) {
        (false, None) => {
            return Err(needs(source, &bearing.kind.span, "a roller bearing", "roller_length_mm"));
        }
        (true, Some(_)) => {
            let message = "a ball has no roller length".to_owned();
            return Err(contradiction(
                source,
                &bearing.roller_length_mm.span,
                message,
                "leave roller_length_mm out",
            ));
        }
        _ => {}
    }
    let (pitch, diameter) = (*bearing.pitch_diameter_mm, *bearing.roller_diameter_mm);
    if diameter >= pitch {
        let message = format!("rollers of {diameter} mm leave no inner ring on a pitch circle of {pitch} mm");
        return Err(contradiction(source, &bearing.roller_diameter_mm.span, message, "both are diameters"));
    }
    if roller_spacing(pitch, *bearing.roller_count) < diameter {
        let fit = (std::f64::consts::PI / (diameter / pitch).asin()).floor();
        let message = format!(
            "{} rollers of {diameter} mm do not fit on the pitch circle of {pitch} mm in bearings.{name}",
            *bearing.roller_count
        );
        return Err(contradiction(source, place, message, &format!("at most {fit} fit")));
    }
    Ok(())
}

/// A larger deviation of the sum of shares from 1 is an error, not rounding.
const LARGEST_ROUNDING: f64 = 0.02;

/// Half a unit of the last digit of a share: its rounding error. Sums within the rounding errors are scaled to
/// 1.
fn half_a_digit(share: f64) -> f64 {
    let digits = share.to_string().split_once('.').map_or(0, |(_, decimals)| decimals.len());
    0.5 * 10_f64.powi(-(digits as i32))
}

pub(super) fn duty(duty: &[At<Section<DutySection>>], load: &LoadSection, source: &Source) -> Result<()> {
    let sum: f64 = duty.iter().map(|row| *row.share).sum();
    let rounding: f64 = duty.iter().map(|row| half_a_digit(*row.share)).sum();
    if !duty.is_empty() && (sum - 1.0).abs() > rounding.min(LARGEST_ROUNDING) + 1e-6 {
        let message = format!("the shares of the duty rows add up to {}, not to 1", plain(sum));
        let place = duty.last().and_then(|row| row.share.span.clone());
        return Err(contradiction(
            source,
            &place,
            message,
            "shares are parts of the running time, not percent",
        ));
    }
    if *load.input_speed_rpm == 0.0 {
        let message = "the rated input speed must not be zero".to_owned();
        return Err(contradiction(
            source,
            &load.input_speed_rpm.span,
            message,
            "give the speed of the motor",
        ));
    }
    Ok(())
}
