//! Single stages with a tooth difference of 2, by the analyses of the commands.

use super::tests::{bench, design, number, random_stages};
use super::*;
use crate::analyses::NoHost;
use crate::checks::Severity;
use crate::design::Design;
use crate::templates::NEMA17_19;

/// The same with a tooth difference of 2, ring or output at rest.
#[test]
#[ignore = "long"]
fn random_stages_of_two_teeth_have_results() {
    random_stages(11, 40, 2);
}

/// The shipped stage with 22 pins and 20 lobes.
fn of_two_teeth(changes: &[(&str, &str)]) -> StageDesign {
    let teeth = [
        ("pin_count = 20 ", "pin_count = 22\ntooth_difference = 2 "),
        ("eccentricity_mm = 0.5", "eccentricity_mm = 0.9"),
    ];
    design(&[&teeth, changes].concat())
}

/// Invalid keys of teeth and tips are refused with their lines; a finding states the end of the flank.
#[test]
fn differences_and_tips_that_cannot_be_are_refused() {
    let text = NEMA17_19
        .text
        .replace("pin_count = 20 ", "pin_count = 22\ntooth_difference = 2 ")
        .replace("eccentricity_mm = 0.5", "eccentricity_mm = 0.9");
    for (from, to, key) in [
        ("tooth_difference = 2", "tooth_difference = 3", "ring.tooth_difference"),
        ("tooth_difference = 2", "tooth_difference = 0", "ring.tooth_difference"),
        ("count = 2\n", "count = 2\nlobe_count = 21\n", "disc.lobe_count"),
        ("count = 2\n", "count = 2\ntip_diameter_mm = 33\n", "disc.tip_diameter_mm"),
        ("count = 2\n", "count = 2\ntip_diameter_mm = 29\n", "disc.tip_diameter_mm"),
        ("pin_count = 22", "pin_count = 4", "ring.pin_count"),
        ("eccentricity_mm = 0.9", "eccentricity_mm = 1.6", "eccentric.eccentricity_mm"),
    ] {
        assert!(text.contains(from), "{from}");
        let error = StageDesign::parse(&text.replacen(from, to, 1), "test.toml").unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
        assert!(error.hint().is_some(), "{error}");
    }
    for (from, to) in [
        ("pin_radius_mm = 3 ", "pin_radius_mm = 3\ntooth_difference = 1 "),
        ("[disc]", "[disc]\ntip_diameter_mm = 120"),
    ] {
        let text = crate::templates::TAO2024.text;
        assert!(text.contains(from), "{from}");
        let error = Design::parse(&text.replacen(from, to, 1), "test.toml").unwrap_err();
        assert!(error.to_string().contains("drives of eccentrics"), "{error}");
    }
    let land = |design: &StageDesign| {
        design
            .findings()
            .into_iter()
            .find(|finding| finding.code == "tip-land")
            .map(|finding| finding.severity)
    };
    let meeting = 2e3 * of_two_teeth(&[]).drive().profile.tip().unwrap().meeting;
    let sharp = format!("count = 2\ntip_diameter_mm = {}\n", meeting - 0.01);
    assert_eq!(land(&of_two_teeth(&[])), Some(Severity::Info));
    assert_eq!(land(&of_two_teeth(&[("count = 2\n", &sharp)])), Some(Severity::Warning));
    assert_eq!(
        land(&of_two_teeth(&[("count = 2\n", "count = 2\ntip_diameter_mm = 30.2\n")])),
        Some(Severity::Warning)
    );
    assert_eq!(land(&design(&[])), None);
    // A flank that ends before its inflection has no convex part, and its lobes touch arcs of a ring less far.
    let hollow = of_two_teeth(&[
        ("count = 2\n", "count = 2\ntip_diameter_mm = 30.2\n"),
        ("pin_count = 22\n", "pin_count = 22\npin_mounting = \"one-piece\"\n"),
    ]);
    let findings = hollow.findings();
    let message = |code: &str| &findings.iter().find(|one| one.code == code).unwrap().message;
    for code in ["undercut", "flank-sharpness"] {
        assert!(message(code).contains("hollow up to the tip"), "{}", message(code));
    }
    // Value and limit are curvatures there, both finite: those of the pin path and of the flank, computed independently.
    let profile = &hollow.drive().profile;
    let end = profile.last_meshing_angle().cos();
    let of = |code: &str| findings.iter().find(|one| one.code == code).unwrap();
    for (code, curvature) in
        [("undercut", -profile.trace_curvature(end)), ("flank-sharpness", -profile.flank_curvature(end))]
    {
        let finding = of(code);
        assert!(curvature < 0.0 && (finding.value / (1e-3 * curvature) - 1.0).abs() < 1e-9, "{finding:?}");
        assert!(finding.value < finding.limit && finding.limit.is_finite() && finding.unit == "1/mm");
    }
    assert!((of("undercut").limit * 1e3 * profile.pin_radius - 1.0).abs() < 1e-12);
    let analysis = crate::analyses::by_name("profile").unwrap();
    let told = AnyDesign::Eccentric(Box::new(hollow.clone())).run(analysis, "", "test", &NoHost).unwrap();
    let (said, page) = (format!("{:?}", told.text_blocks()), format!("{:?}", told.page()));
    assert!(said.contains("hollow up to the tip") && !said.contains("inf mm"), "{said}");
    assert!(page.contains("hollow up to the tip") && !page.contains("\"inf\""));
    let change = |design: &StageDesign| {
        design.findings().into_iter().find(|finding| finding.code == "tip-land").unwrap().change
    };
    assert!(change(&hollow).contains("larger tip"));
    assert!(change(&of_two_teeth(&[("count = 2\n", &sharp)])).contains("smaller tip"));
    // Complete lobes have no corner at the tip.
    let too_large = NEMA17_19.text.replacen("count = 2\n", "count = 2\ntip_diameter_mm = 36\n", 1);
    let error = StageDesign::parse(&too_large, "test.toml").unwrap_err().to_string();
    assert!(error.contains("31.98 mm, which whole lobes have"), "{error}");
    // A tooth difference that equals the default, and a tip circle outside of all contacts, do not change the results.
    let one = design(&[("pin_count = 20 ", "tooth_difference = 1\npin_count = 20 ")]);
    assert_eq!(one.drive(), design(&[]).drive());
}

/// Without gaps and with springs that are soft against bearings, forces are near the closed forms; the losses with a driven housing are the same. The volume lost by the flanks
/// follows from the work of sliding. Bench, life and motion agree with the ratio.
#[test]
#[ignore = "long"]
fn all_analyses_support_a_stage_of_two_teeth() {
    let tight = of_two_teeth(&[
        ("hole_clearance_um = 10 ", "hole_clearance_um = 0 "),
        ("clearance_um = 6\n", "clearance_um = 0\n"),
        ("equidistant_offset_um = 10 ", "equidistant_offset_um = 0 "),
        ("[drive]", "[contact]\nlaw = \"linear\"\nstiffness_n_per_um = 2\n[drive]"),
        (
            "kind = \"ball\"\nroller_count = 7",
            "kind = \"cylindrical\"\nroller_length_mm = 5\nroller_count = 14",
        ),
        ("input_radial_stiffness_n_per_um = 30", "input_radial_stiffness_n_per_um = 1e5"),
        ("output_radial_stiffness_n_per_um = 100", "output_radial_stiffness_n_per_um = 1e5"),
    ]);
    assert_eq!(tight.ratio(), -10.0);
    let contact =
        contact::run(&tight, &contact::Options::parse("positions = 60", "test").unwrap(), &NoHost).unwrap();
    for (found, closed, within) in [
        ("max_force_n", "closed_form.ring_pin_force_n", 0.05),
        ("max_output_pin_force_n", "closed_form.output_pin_force_n", 0.35),
        ("eccentric_bearing_force_n", "closed_form.eccentric_bearing_force_n", 0.1),
    ] {
        let (found, closed) = (number(&contact, found), number(&contact, closed));
        assert!((found / closed - 1.0).abs() < within, "{found} {closed}");
    }
    let open = of_two_teeth(&[]);
    let rig = bench(&open);
    let total = open.play_chain().total();
    assert!(rig.play[0] > 0.999 * total && rig.play[1] < 1.25 * total, "{:?} {total}", rig.play);
    let driven = of_two_teeth(&[("fixed_member = \"ring\" ", "fixed_member = \"output\" ")]);
    assert_eq!(driven.ratio(), 11.0);
    let other = bench(&driven);
    assert!(
        (other.play[0] / rig.play[0] / (10.0 / 11.0) - 1.0).abs() < 0.02,
        "{:?} {:?}",
        other.play,
        rig.play
    );
    let share = wear_tests::loss_over_work_of_sliding(&open, 1e-18, 0);
    assert!((share - 1.0).abs() < 1e-2, "{share}");
    series_tests::moves(&AnyDesign::Eccentric(Box::new(open)), "rigid");
    series_tests::moves(&AnyDesign::Eccentric(Box::new(driven)), "elastic");
}

/// Pins at the corner of a tip of soft discs: forces that depend on the displacement of the contact point along the deformed
/// flank are continuous there, so that every torque has a static equilibrium.
#[test]
#[ignore = "long"]
fn soft_teeth_carry_up_to_their_corners() {
    let pa12 =
        "material = { name = \"PA12\", youngs_modulus_gpa = 1.7, poisson_ratio = 0.4, density_g_cm3 = 0.93 }";
    let design = of_two_teeth(&[
        ("pin_count = 22", "pin_count = 24"),
        ("pin_circle_radius_mm = 17", "pin_circle_radius_mm = 24.2"),
        ("pin_radius_mm = 1.5                  # dowel pins of 3 mm", "pin_radius_mm = 1"),
        ("eccentricity_mm = 0.9", "eccentricity_mm = 1.11"),
        ("width_mm = 5\nmaterial = \"100Cr6\"", &format!("width_mm = 8.5\n{pa12}")),
        ("crank_bore_diameter_mm = 13 ", "crank_bore_diameter_mm = 17 "),
        ("equidistant_offset_um = 10 ", "equidistant_offset_um = 130 "),
        ("count = 6\ncircle_radius_mm = 10.5", "count = 8\ncircle_radius_mm = 15.2"),
        ("roller_radius_mm = 2 ", "roller_radius_mm = 3.5 "),
        ("hole_clearance_um = 10 ", "hole_clearance_um = 105 "),
    ]);
    let options = made::MadeOptions::default().with_discs(crate::fidelity::DiscBodies::Elastic);
    let made = design.as_made(&options, &NoHost).unwrap();
    let mut drive = made.design.new_drive(&made.discs).unwrap();
    let end = design.drive().profile.last_meshing_angle();
    let mut at_corner = 0;
    // Steps smaller than the torque range of such a discontinuity.
    let mut start = None;
    for step in 0..120 {
        let angle = 60.0_f64.to_radians();
        let (place, _) = drive.rest(angle, 2.0 + 0.03 * step as f64, start.as_deref()).unwrap();
        let loaded = drive.joints().pin_contacts(0, &place).into_iter().filter(|pin| pin.force > 0.0);
        at_corner += loaded.filter(|pin| (end - pin.meshing_angle.abs()).abs() < 1e-6).count();
        start = Some(drive.deviation(angle, &place));
    }
    assert!(at_corner > 3, "{at_corner}");
}
