//! Systematic deviations of the processes by which drives of eccentrics are made.

use super::EccentricDrive;
use super::findings::ring_of;
use super::made::MadePlay;
use crate::checks::{Finding, Severity};
use crate::design::StageProcess;
use crate::machine::{StageErrors, StageOffsets};
use crate::units::{ARCMIN, MM, UM};

/// Sentence about the deviations that are not zero.
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

/// Sentence about the deviations of the stages that are compensated or not, and about the holes to draw.
struct Deviations {
    of: String,
    holes: String,
}

fn deviations<D: EccentricDrive>(design: &D, compensated: bool) -> Option<Deviations> {
    let several = D::STAGES.len() > 1;
    let (mut of, mut holes) = (Vec::new(), Vec::new());
    for ((process, hole), stage) in design.processes().into_iter().zip(design.hole_diameters()).zip(D::STAGES)
    {
        let Some(StageProcess { offsets, .. }) = process.filter(|process| process.compensated == compensated)
        else {
            continue;
        };
        if offsets == StageOffsets::default() {
            continue;
        }
        let (at, of_stage) = match several {
            true => (format!(" ({})", stage.name), format!(" of the {}", stage.name)),
            false => (String::new(), String::new()),
        };
        of.push(format!("{}{at}", words(&offsets)));
        if let Some(hole) = hole.filter(|_| offsets.hole_diameter != 0.0) {
            holes.push(format!(
                "a hole of {:.3} mm{of_stage} {} drawn with {:.3} mm",
                hole / MM,
                if compensated { "is" } else { "must be" },
                (hole - offsets.hole_diameter) / MM
            ));
        }
    }
    (!of.is_empty()).then(|| Deviations { of: of.join("; "), holes: holes.join(", ") })
}

/// Findings about compensated deviations, and about the effect of uncompensated ones; empty without deviations.
pub(in crate::analyses) fn findings<D: EccentricDrive>(design: &D, made: Option<&MadePlay>) -> Vec<Finding> {
    let compensated = deviations(design, true).map(|Deviations { of, holes }| {
        let holes = if holes.is_empty() { holes } else { format!(": {holes}") };
        let message = format!("the process causes {of}, which drawing or slicer must compensate{holes}");
        finding(Severity::Info, message, (0.0, ""))
    });
    let remaining = deviations(design, false).map(|found| effect(design, made, &found));
    compensated.into_iter().chain(remaining).collect()
}

/// Finding about uncompensated deviations.
fn effect<D: EccentricDrive>(design: &D, made: Option<&MadePlay>, found: &Deviations) -> Finding {
    let Deviations { of, holes } = found;
    if let Some(Some(play)) = made.and_then(|made| made.systematic) {
        let nominal = made.and_then(|made| made.nominal);
        let nominal = nominal.map_or("–".to_owned(), |play| format!("{:.2}′", play / ARCMIN));
        let play = play / ARCMIN;
        let message =
            format!("the process causes {of}: without scatter the play is {play:.2}′, as drawn {nominal}");
        return finding(Severity::Info, message, (play, "arcmin"));
    }
    let of_stage = |(counts, process): (_, Option<StageProcess>)| {
        let offsets = process.map_or_else(StageOffsets::default, |process| process.remaining());
        StageErrors::systematic(counts, &offsets)
    };
    let errors: Vec<StageErrors> =
        design.part_counts().into_iter().zip(design.processes()).map(of_stage).collect();
    let by = design.gap_chain().overlap(&errors).map_or(String::new(), |overlap| {
        format!(
            ", overlapping by {:.0} µm at the {}",
            overlap.depth / UM,
            overlap.place.words(ring_of(design))
        )
    });
    let holes = if holes.is_empty() { String::new() } else { format!("; {holes}") };
    let message = format!("the process causes {of}: without scatter the drive jams{by}{holes}");
    finding(Severity::Error, message, (0.0, "arcmin"))
}

fn finding(severity: Severity, message: String, (value, unit): (f64, &'static str)) -> Finding {
    Finding {
        code: "process-offsets",
        severity,
        message,
        value,
        limit: 0.0,
        unit,
        why: "a process that makes all holes too small or all flanks too thick reduces the gaps of every drive; \
             tolerances do not contain this",
        change: "draw holes and flanks with the compensation of the process, or set it in the slicer; chamfer the \
             edge of the first layer, \
                 and write compensated = true",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};
    use crate::machine::{GapChain, StageTolerances};
    use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500};

    fn design(process: &str) -> StageDesign {
        let text = format!("{}\n[process]\n{process}\n", NEMA17_19.text);
        StageDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
    }

    fn play(design: &StageDesign) -> Option<f64> {
        let offsets = design.tolerances().unwrap().offsets;
        GapChain::new(design.drive())
            .least(&[StageErrors::systematic(design.drive().part_counts(), &offsets)])
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
            let drawn = GapChain::new(drawn.drive()).least(&[StageErrors::default()]).unwrap();
            assert!((made / drawn - 1.0).abs() < 2e-3, "{process}: {made} {drawn}");
        }
        // The first layer reduces the gaps of flank and holes equally.
        let foot = play(&design("elephant_foot_um = 3")).unwrap();
        let both = play(&design("flank_um = -3\nhole_diameter_um = -6")).unwrap();
        assert!((foot / both - 1.0).abs() < 1e-12);
    }

    /// By bisection: flanks jam if they are larger by their gap; the same applies to the first layer. Pins press holes along the
    /// eccentric: holes jam if they are smaller by their clearance plus the radial clearance of the eccentric bearing, by which
    /// the disc can move.
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

    /// Presets: holes printed from filament are too small and jam this drive with gaps for steel, and all drawn drives. With
    /// compensation the dimensions are those of the drawing. Tolerances are set part by part; those in the file are kept.
    #[test]
    fn processes_give_offsets_and_tolerances_by_part() {
        let printed = design("disc = \"printed-fdm\"");
        let made = MadePlay::of(&printed).unwrap();
        assert_eq!((made.systematic, made.drawn.jam_rate), (Some(None), 1.0));
        assert_eq!(findings(&printed, Some(&made))[0].severity, Severity::Error);
        let compensated = design("disc = \"printed-fdm\"\ncompensated = true");
        assert_eq!(compensated.tolerances().unwrap().offsets, StageOffsets::default());
        let told = &findings(&compensated, MadePlay::of(&compensated).as_ref())[0];
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
        assert!(findings(&design("disc = \"milled\""), None).is_empty());
    }

    fn single(text: &str) -> StageDesign {
        StageDesign::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
    }

    /// The two stages of a drive as single stages of their own: their sections are those of the file.
    fn alone(process: &str) -> [StageDesign; 2] {
        let text = TWO_STAGE_500.text.replace("\"two-stage\"", "\"eccentric\"");
        let is_first = |section: &str| section.starts_with("[first_stage.");
        let (mut first, mut second) = (String::new(), String::new());
        for (number, section) in text.split("\n[").enumerate() {
            let section = if number == 0 { section.to_owned() } else { format!("[{section}") };
            let of_drive = number == 0
                || ["[drive]", "[load]", "[friction]", "[contact]"]
                    .iter()
                    .any(|head| section.starts_with(head));
            if is_first(&section) || of_drive {
                first.push_str(&section.replace("[first_stage.", "["));
                first.push('\n');
            }
            if !is_first(&section) {
                second.push_str(&section);
                second.push('\n');
            }
        }
        [first, second].map(|text| single(&format!("{text}\n[process]\n{process}\n")))
    }

    const EVERY_PART: &str = "disc = \"printed-fdm\"\nring = \"milled\"\neccentric = \"ground\"\noutput = \"wire-edm\"\npin_circle_radius_um = 7\neccentric_clearance_um = -2\n";

    /// Two stages of equal processes have the tolerances and deviations of two single stages, and the play that both have alone,
    /// that of the first over the ratio of the second.
    #[test]
    fn two_stages_are_two_single_stages() {
        for more in
            ["", "compensated = true\n", "flank_um = 20\nhole_diameter_um = 14\nelephant_foot_um = 3\n"]
        {
            let process = format!("{EVERY_PART}{more}");
            let text =
                format!("{}\n[first_stage.process]\n{process}[process]\n{process}", TWO_STAGE_500.text);
            let both = TwoStageDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
            let stages = alone(&process);
            let tolerances = both.tolerances().unwrap();
            for (of_drive, stage) in tolerances.iter().zip(&stages) {
                assert_eq!(*of_drive, stage.tolerances().unwrap());
            }
            assert!((tolerances[0].flank_offset / UM - 100.0).abs() < 1e-9);
            assert!((tolerances[1].eccentricity / UM - 2.0).abs() < 1e-9);
            let whole = systematic(&both, &tolerances);
            let alone = stages.each_ref().map(|design| systematic(design, &[design.tolerances().unwrap()]));
            match alone {
                [Some(first), Some(second)] => {
                    let sum = second + first / both.drive().second.ratio().abs();
                    let whole = whole.unwrap();
                    assert!(!more.is_empty() && (whole / sum - 1.0).abs() < 5e-3, "{more:?}: {whole} {sum}");
                }
                _ => assert!(whole.is_none() && more.is_empty(), "{more:?}"),
            }
        }
        let one = format!("{}\n[first_stage.process]\nflank_um = -4\n", TWO_STAGE_500.text);
        let one = TwoStageDesign::parse(&one, "test.toml").unwrap();
        let told = findings(&one, MadePlay::of(&one).as_ref());
        assert_eq!(told.len(), 1);
        assert!(
            told[0].message.contains("metal on the flanks +4 µm (first stage): without scatter"),
            "{told:?}"
        );
    }

    /// The play with the systematic deviations alone.
    fn systematic<D: EccentricDrive>(design: &D, tolerances: &[StageTolerances]) -> Option<f64> {
        let counts = design.part_counts().into_iter();
        let errors = counts.zip(tolerances).map(|(counts, t)| StageErrors::systematic(counts, &t.offsets));
        design.gap_chain().least(&errors.collect::<Vec<_>>())
    }

    /// A drive of two rings with systematic deviations has the play of one that is drawn with them; tolerances and presets go
    /// to the ring of their section, those of the discs to both steps, the foot to the step that lies on the bed.
    #[test]
    fn two_rings_have_the_deviations_of_their_sections() {
        let read =
            |text: &str| TwoRingDesign::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
        let with = |sections: &str| read(&format!("{}\n{sections}\n", TWO_RING_225.text));
        let play = |design: &TwoRingDesign| systematic(design, &design.tolerances().unwrap_or_default());
        let nominal = systematic(&with(""), &[StageTolerances::default(); 2]).unwrap();
        let drawn = |place: &str, offset: f64| {
            let gap = "equidistant_offset_um = 5";
            let key = format!("[{place}.modification]\n{gap}");
            let (before, after) = TWO_RING_225.text.split_once(&format!("[{place}.modification]")).unwrap();
            assert!(TWO_RING_225.text.contains(gap), "{key}");
            let after = after.replacen(gap, &format!("equidistant_offset_um = {offset}"), 1);
            systematic(
                &read(&format!("{before}[{place}.modification]{after}")),
                &[StageTolerances::default(); 2],
            )
            .unwrap()
        };
        for (section, place) in [("process", "disc"), ("second_process", "second_disc")] {
            for flank in [-2.0, 6.0] {
                let made = play(&with(&format!("[{section}]\nflank_um = {flank}"))).unwrap();
                let drawn = drawn(place, 5.0 + flank);
                assert!((made / drawn - 1.0).abs() < 2e-3, "{section} {flank}: {made} {drawn}");
                assert!((made - nominal).abs() > 0.05 * nominal, "{section} {flank}: {made} {nominal}");
            }
            let jammed = with(&format!("[{section}]\nflank_um = -9"));
            let told = findings(&jammed, MadePlay::of(&jammed).as_ref());
            assert!(told[0].severity == Severity::Error && told[0].message.contains("jams"), "{told:?}");
            assert!(!told[0].message.contains("a hole"), "{told:?}");
        }
        let by_part = with(
            "[process]\ndisc = \"printed-fdm\"\nring = \"milled\"\neccentric = \"ground\"\n[second_process]\nring = \"printed-sls\"\n[second_tolerances]\npin_radius_um = 1",
        );
        let [first, second] = by_part.tolerances().unwrap();
        let um = [
            (first.flank_offset, 100.0),
            (first.pin_position, 4.0),
            (first.eccentricity, 2.0),
            (first.offsets.elephant_foot, 100.0),
            (second.flank_offset, 100.0),
            (second.pin_position, 50.0),
            (second.pin_radius, 1.0),
            (second.eccentricity, 0.0),
            (second.offsets.elephant_foot, 0.0),
        ];
        for (found, um) in um {
            assert!((found / UM - um).abs() < 1e-9, "{found:e} {um}");
        }
        let discs_alone = with("[process]\ndisc = \"milled\"\ncompensated = true").tolerances().unwrap();
        assert!(discs_alone.iter().all(|t| t.flank_offset > 0.0 && t.pin_position == 0.0));
    }
}
