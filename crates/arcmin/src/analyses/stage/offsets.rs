//! Systematic deviations of the processes of a single stage.

use super::made::MadePlay;
use crate::checks::{Finding, Severity};
use crate::design::StageDesign;
use crate::machine::{GapChain, StageErrors, StageOffsets};
use crate::units::{ARCMIN, MM, UM};

/// Deviations in words, of those that are there.
fn words(offsets: &StageOffsets) -> String {
    let all = [
        (offsets.hole_diameter, "diameter of the holes of output pins"),
        (-offsets.flank, "metal on the flanks"),
        (offsets.elephant_foot, "first layer beyond flank and holes"),
        (offsets.pin_circle_radius, "radius of the pin circle"),
        (offsets.eccentric_clearance, "clearance of the eccentric bearings"),
    ];
    let there = all.iter().filter(|(size, _)| *size != 0.0);
    there.map(|(size, name)| format!("{name} {:+.0} µm", size / UM)).collect::<Vec<_>>().join(", ")
}

/// Effect of the deviations, or the correction that drawing and slicer must make; `None` where parts come out
/// as drawn.
pub(super) fn finding(design: &StageDesign, made: Option<&MadePlay>) -> Option<Finding> {
    let process = design.process.value.as_ref()?;
    let offsets = process.offsets();
    if offsets == StageOffsets::default() {
        return None;
    }
    let (stage, deviations) = (design.stage(), words(&offsets));
    let hole = 2.0 * stage.output_pins.hole_radius(stage.profile.eccentricity);
    let drawn = hole - offsets.hole_diameter;
    let (severity, message, value) = match made.and_then(|made| made.systematic) {
        _ if *process.compensated => (
            Severity::Info,
            format!(
                "parts come out with {deviations}, which drawing or slicer must take back: a hole of {:.3} mm is drawn with {:.3} mm",
                hole / MM,
                drawn / MM
            ),
            0.0,
        ),
        Some(Some(play)) => {
            let nominal = made
                .and_then(|made| made.nominal)
                .map_or("–".to_owned(), |play| format!("{:.2}′", play / ARCMIN));
            let message = format!(
                "parts come out with {deviations}: without scatter the play is {:.2}′, as drawn {nominal}",
                play / ARCMIN
            );
            (Severity::Info, message, play / ARCMIN)
        }
        _ => {
            let errors = StageErrors::systematic(stage.part_counts(), &offsets);
            let overlap = GapChain::new(stage).overlap(&[errors]);
            let by = overlap.map_or(String::new(), |overlap| {
                format!(", overlapping by {:.0} µm at the {}", overlap.depth / UM, overlap.place.words())
            });
            let message = format!(
                "parts come out with {deviations}: without any scatter the drive jams{by}; a hole of {:.3} mm must be drawn with {:.3} mm",
                hole / MM,
                drawn / MM
            );
            (Severity::Error, message, 0.0)
        }
    };
    Some(Finding {
        code: "process-offsets",
        severity,
        message,
        value,
        limit: 0.0,
        unit: if *process.compensated { "" } else { "arcmin" },
        why: "a process that makes all holes too small or all flanks too thick closes gaps in every drive alike; tolerances do not contain it",
        change: "draw holes and flanks with what the process takes, or set its compensation in the slicer, break the edge of the first layer, \
                 and write compensated = true",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::templates::NEMA17_19;

    fn design(process: &str) -> StageDesign {
        let text = format!("{}\n[process]\n{process}\n", NEMA17_19.text);
        StageDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
    }

    fn play(design: &StageDesign) -> Option<f64> {
        let offsets = design.tolerances().unwrap().offsets;
        GapChain::new(design.stage())
            .least(&[StageErrors::systematic(design.stage().part_counts(), &offsets)])
    }

    /// A drive with systematic deviations has the play of one that is drawn with them.
    #[test]
    fn deviations_are_another_drawing() {
        for (process, key, value) in [
            ("hole_diameter_um = 14", "output_pins.hole_clearance_um", 17.0),
            ("flank_um = -4", "disc.modification.equidistant_offset_um", 6.0),
            ("eccentric_clearance_um = -3", "bearings.eccentric.clearance_um", 3.0),
        ] {
            let made = play(&design(process)).unwrap();
            let drawn = design("").with_all([(key, value)]).unwrap();
            let drawn = GapChain::new(drawn.stage()).least(&[StageErrors::default()]).unwrap();
            assert!((made / drawn - 1.0).abs() < 2e-3, "{process}: {made} {drawn}");
        }
        // A foot takes from flank and holes alike.
        let foot = play(&design("elephant_foot_um = 3")).unwrap();
        let both = play(&design("flank_um = -3\nhole_diameter_um = -6")).unwrap();
        assert!((foot / both - 1.0).abs() < 1e-12);
    }

    /// By bisection: flanks jam when they stand out by their gap, a foot too. Pins press holes along the eccentric, so that holes
    /// jam when they are smaller by their clearance and the radial clearance of the eccentric bearing, by which a disc gives way.
    #[test]
    fn drives_jam_where_the_gaps_end() {
        for (key, sign, closed) in
            [("hole_diameter_um", -1.0, 26.0), ("flank_um", -1.0, 10.0), ("elephant_foot_um", 1.0, 10.0)]
        {
            let (mut open, mut jammed) = (0.0_f64, 40.0);
            while jammed - open > 0.01 {
                let middle = 0.5 * (open + jammed);
                match play(&design(&format!("{key} = {}", sign * middle))) {
                    Some(_) => open = middle,
                    None => jammed = middle,
                }
            }
            assert!((open / closed - 1.0).abs() < 0.01, "{key}: {open} {closed}");
        }
    }

    /// Presets: holes from filament are too small and jam this drive of steel sizes, also all that are drawn; what is compensated is
    /// as drawn; tolerances come part by part, and what the file gives itself stays.
    #[test]
    fn processes_give_offsets_and_tolerances_by_part() {
        let printed = design("disc = \"printed-fdm\"");
        let made = MadePlay::of(&printed).unwrap();
        assert_eq!((made.systematic, made.drawn.jam_rate), (Some(None), 1.0));
        assert_eq!(finding(&printed, Some(&made)).unwrap().severity, Severity::Error);
        let compensated = design("disc = \"printed-fdm\"\ncompensated = true");
        assert_eq!(compensated.tolerances().unwrap().offsets, StageOffsets::default());
        let told = finding(&compensated, MadePlay::of(&compensated).as_ref()).unwrap();
        assert!(
            told.severity == Severity::Info && told.message.contains("is drawn with 5.320 mm"),
            "{told:?}"
        );
        let by_part = design("disc = \"printed-fdm\"\nring = \"milled\"\n[tolerances]\nbore_position_um = 7");
        let t = by_part.tolerances().unwrap();
        let found = [t.flank_offset, t.bore_position, t.pin_position, t.eccentricity, t.output_pin_position];
        for (found, um) in found.iter().zip([100.0, 7.0, 4.0, 0.0, 0.0]) {
            assert!((found / UM - um).abs() < 1e-9, "{found:e} {um}");
        }
        assert!(MadePlay::of(&design("disc = \"milled\"")).is_some());
        assert!(finding(&design("disc = \"milled\""), None).is_none());
    }
}
