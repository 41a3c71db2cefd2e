//! Drives of two rings and of two stages as made.

use super::made::MadePlay;
use super::*;
use crate::analyses::NoHost;
use crate::machine::StageErrors;
use crate::results::Value;
use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500};

const RING: &str =
    "pin_position_um = 3\npin_circle_radius_um = 5\nflank_offset_um = 3\nflank_run_out_um = 3\n";
const ECCENTRIC: &str = "eccentricity_um = 2\neccentric_clearance_um = 3\n";

fn families() -> [(AnyDesign, [&'static str; 2]); 2] {
    let two_ring = format!(
        "{}\n[tolerances]\n{RING}{ECCENTRIC}[second_tolerances]\n{RING}flank_turn_um = 3\n",
        TWO_RING_225.text
    );
    let two_stage = format!(
        "{}\n[tolerances]\n{RING}{ECCENTRIC}bore_position_um = 3\n[first_stage.tolerances]\n{RING}bore_diameter_um = 4\n",
        TWO_STAGE_500.text
    );
    // Gaps that are wide enough for these errors.
    let any = |text: &str| {
        let text = text.replace("equidistant_offset_um = 5", "equidistant_offset_um = 20");
        let text = text.replace("equidistant_offset_um = 8", "equidistant_offset_um = 20");
        AnyDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
    };
    [
        (any(&two_ring), ["tolerances", "second_tolerances"]),
        (any(&two_stage), ["first_stage.tolerances", "tolerances"]),
    ]
}

/// The quicker discs, where errors are the subject.
const RIGID: &str = "discs = \"rigid\"";

fn asked(design: &AnyDesign, name: &str, options: &str) -> Result<Box<dyn Outcome>, AnalysisError> {
    design.run(crate::analyses::by_name(name).unwrap(), options, "test", &NoHost)
}

/// Equal seeds give equal drives. The play by gaps is at most that of static equilibria at some positions.
#[test]
fn drawn_drives_of_every_family_are_computed() {
    for (design, _) in families() {
        assert!(design.has_tolerances());
        let rig = |options: &str| {
            let options = format!("positions = 3\nte_positions = 12\ndiscs = \"rigid\"\n{options}");
            asked(&design, "rig", &options).unwrap().summary()
        };
        let plays: Vec<f64> = (1..4)
            .map(|seed| {
                let summary = rig(&format!("errors = \"drawn\"\nseed = {seed}"));
                let number = |key: &str| summary.number(key).unwrap();
                let (gaps, rests) = (number("gap_play_arcmin"), number("least_play_arcmin"));
                assert!(gaps < 1.02 * rests && gaps > 0.7 * rests, "{gaps} {rests}");
                assert_eq!(number("errors.seed"), seed as f64);
                gaps
            })
            .collect();
        assert!(plays.windows(2).all(|pair| pair[0] != pair[1]), "{plays:?}");
        let again = rig("errors = \"drawn\"\nseed = 3").number("gap_play_arcmin");
        assert_eq!(again, Some(plays[2]));
        let force = |options: &str| {
            let contact = asked(&design, "contact", &format!("positions = 8\n{options}")).unwrap().summary();
            contact.number("max_force_n")
        };
        assert!(force("errors = \"drawn\"") != force(""));
        assert_eq!(force("errors = \"none\""), force(""));
        assert!(asked(&design, "contact", "errors = \"given\"").is_err());
    }
}

/// The mean of an exact series is the nominal play, every tolerance is named by its section, and a single tolerance has all the
/// variance: a depth h of flanks increases the play by its closed form.
#[test]
fn tolerances_are_named_by_their_sections() {
    for (design, sections) in families() {
        let check = asked(&design, "check", "").unwrap();
        let summary = check.summary();
        let number = |key: &str| summary.number(key).unwrap();
        let (mean, nominal) = (number("play_as_made.mean_arcmin"), number("play_as_made.nominal_arcmin"));
        assert!(mean < nominal && mean > 0.5 * nominal, "{mean} {nominal}");
        assert!(number("play_as_made.jam_rate") < 0.05);
        let tables = check.tables();
        let tolerances = tables.iter().find(|table| table.name == "tolerances").unwrap();
        for section in sections {
            let cells = &tolerances.column("section").unwrap().cells;
            let rows = (0..cells.len()).filter(|row| cells.value(*row) == Value::Word(section.to_owned()));
            assert!(rows.count() >= 5, "{section}");
        }
        for (stage, section) in sections.into_iter().enumerate() {
            let template = if design.family() == Family::TwoRing { TWO_RING_225 } else { TWO_STAGE_500 };
            let text = format!("{}\n[{section}]\nflank_offset_um = 6\n", template.text);
            let one = AnyDesign::parse(&text, "test.toml").unwrap();
            let made = match &one {
                AnyDesign::TwoRing(design) => MadePlay::of(&**design),
                AnyDesign::TwoStage(design) => MadePlay::of(&**design),
                _ => None,
            };
            let made = made.unwrap();
            assert_eq!(made.tolerances[0].path(), format!("{section}.flank_offset_um"));
            assert!((made.tolerances[0].variance_share - 1.0).abs() < 1e-9);
            // ±2 µm of standard deviation times the play per depth.
            let per_depth = match &one {
                AnyDesign::TwoRing(design) => {
                    let mesh = &design.drive().meshes[stage];
                    2.0 / mesh.lever() * design.drive().per_disc()
                }
                AnyDesign::TwoStage(design) => {
                    let drive = design.drive();
                    let seen = [1.0 / drive.second.ratio().abs(), 1.0][stage];
                    2.0 * seen / [&drive.first, &drive.second][stage].lever()
                }
                _ => 0.0,
            };
            let spread = made.drawn.quantile(0.95).unwrap() - made.drawn.quantile(0.05).unwrap();
            let expected = 2.0 * 1.645 * 2e-6 * per_depth;
            assert!((spread / expected - 1.0).abs() < 0.1, "{section}: {spread} {expected}");
        }
    }
}

/// Thinner pins increase the play of one ring like a deeper cut; a thick pin jams; a rotation of the second steps against the
/// first does not change the play of one disc; parts that do not exist are refused.
#[test]
fn given_errors_of_every_family_are_taken() {
    let [(two_ring, _), (two_stage, _)] = families();
    let play = |design: &AnyDesign, more: &str| {
        let text = format!("{}\n{more}", design.text());
        let design = AnyDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
        let options = "positions = 1\nte_positions = 8\ndiscs = \"rigid\"";
        asked(&design, "rig", options).unwrap().summary().number("gap_play_arcmin")
    };
    for (design, [first, second], keys) in [
        (
            &two_ring,
            ["[errors]", "[second_errors]"],
            ["disc.modification.equidistant_offset_um", "second_disc.modification.equidistant_offset_um"],
        ),
        (
            &two_stage,
            ["[first_stage.errors]", "[errors]"],
            [
                "first_stage.disc.modification.equidistant_offset_um",
                "disc.modification.equidistant_offset_um",
            ],
        ),
    ] {
        for (section, key) in [first, second].into_iter().zip(keys) {
            let thin = play(design, &format!("{section}\npin_radius_um = -5\n")).unwrap();
            let offset = design.get(key).unwrap().as_number().unwrap();
            let deep = play(&design.with(key, offset + 5.0).unwrap(), "").unwrap();
            assert!((thin / deep - 1.0).abs() < 2e-3, "{key}: {thin} {deep}");
            assert!(thin > play(design, "").unwrap());
            let thick =
                format!("{}\nradius_um = 90\npin = 4\n", section.replace('[', "[[").replace(']', ".pins]]"));
            assert_eq!(play(design, &thick), None, "{thick}");
        }
    }
    let turned = play(
        &two_ring,
        "[[second_errors.flanks]]\ndisc = 1\nkind = \"pitch\"\norder = 0\namplitude_um = 5\n",
    );
    assert!((turned.unwrap() / play(&two_ring, "").unwrap() - 1.0).abs() < 5e-3, "{turned:?}");
    for (design, more, key) in [
        (&two_ring, "[[errors.pins]]\npin = 17\n", "errors.pins[0].pin"),
        (&two_ring, "[errors]\noutput_pin_radius_um = 3\n", "errors.output_pin_radius_um"),
        (
            &two_ring,
            "[[second_errors.flanks]]\ndisc = 2\nkind = \"profile\"\norder = 1\namplitude_um = 1\n",
            "second_errors.flanks[0].disc",
        ),
        (&two_stage, "[[first_stage.errors.holes]]\ndisc = 1\npin = 50\n", "first_stage.errors.holes[0].pin"),
    ] {
        let text = format!("{}\n{more}", design.text());
        let error = AnyDesign::parse(&text, "test.toml").unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
    }
}

/// A drive with its errors, drawn.
fn drawn<D: EccentricDrive>(design: &AnyDesign, seed: u64) -> D {
    let design = D::of_any(design).unwrap();
    let stages: Vec<_> = design.part_counts().into_iter().zip(design.tolerances().unwrap()).collect();
    design.with_errors(StageErrors::draw(&stages, seed, None))
}

fn single() -> AnyDesign {
    let text = format!("{}\n[tolerances]\n{RING}{ECCENTRIC}bore_position_um = 3\n", NEMA17_19.text);
    AnyDesign::parse(&text, "test.toml").unwrap()
}

/// Metal lost by all flanks of a drive with errors is k Σ F |v| of its contacts over the full period.
#[test]
fn metal_lost_with_errors_is_the_work_of_sliding() {
    let [(two_ring, _), _] = families();
    let one = drawn::<StageDesign>(&single(), 3);
    let both = drawn::<TwoRingDesign>(&two_ring, 3);
    let shares = [
        wear_tests::loss_over_work_of_sliding(&one, 1e-18, 0),
        wear_tests::loss_over_work_of_sliding(&both, 1e-18, 0),
        wear_tests::loss_over_work_of_sliding(&both, 1e-18, 1),
    ];
    for share in shares {
        assert!((share - 1.0).abs() < 0.03, "{shares:?}");
    }
}

/// A drive with thinner pins wears like one with a deeper cut. For a drawn drive lost motion of the life equals that of the
/// bench, new and at the end, and every disc has a separate flank.
#[test]
#[ignore = "long"]
fn lives_with_errors_agree_with_the_bench() {
    let [(two_ring, _), (two_stage, _)] = families();
    for (design, errors, key) in [
        (single(), "errors", "disc.modification.equidistant_offset_um"),
        (two_ring, "errors", "disc.modification.equidistant_offset_um"),
        (two_stage, "first_stage.errors", "first_stage.disc.modification.equidistant_offset_um"),
    ] {
        let text = design.text().replace("coefficient_per_pa = 1e-18 ", "coefficient_per_pa = 5e-18 ");
        let text = text.replace("service_life_h = 2000", "service_life_h = 400");
        let any = |more: &str| AnyDesign::parse(&format!("{text}\n{more}"), "test.toml").unwrap();
        let summary = |design: &AnyDesign, name: &str, options: &str| {
            asked(design, name, options).unwrap_or_else(|error| panic!("{name} {error:?}")).summary()
        };
        let plain = any("");
        let thin = any(&format!("[{errors}]\npin_radius_um = -4\n"));
        let offset = plain.get(key).unwrap().as_number().unwrap();
        let deep = plain.with(key, offset + 4.0).unwrap();
        let wear = format!("points = 2\n{RIGID}");
        let (thin, deep) = (summary(&thin, "wear", &wear), summary(&deep, "wear", &wear));
        let (one, other) = (thin.number("max_depth_um").unwrap(), deep.number("max_depth_um").unwrap());
        assert!((one / other - 1.0).abs() < 0.01 && one > 0.3, "{key} {one} {other}");
        let options = "errors = \"drawn\"\nseed = 2";
        let life = summary(&plain, "life", &format!("points = 4\n{options}\n{RIGID}"));
        assert_eq!(life.number("errors.seed"), Some(2.0));
        for (hours, key) in [(0, "lost_motion_new_arcmin"), (400, "lost_motion_arcmin")] {
            let asked = format!("hours = {hours}\npositions = 24\nte_positions = 8\n{options}\n{RIGID}");
            let bench = summary(&plain, "rig", &asked).number("lost_motion_arcmin").unwrap();
            let found = life.number(key).unwrap();
            // Either is a mean over some positions of a turn of the output.
            assert!((found / bench - 1.0).abs() < 0.02, "{key}: {found} {bench}");
        }
        let new = life.number("lost_motion_new_arcmin").unwrap();
        assert!(life.number("lost_motion_arcmin").unwrap() > new);
        let nominal = summary(&plain, "life", &format!("points = 4\n{RIGID}"))
            .number("lost_motion_new_arcmin")
            .unwrap();
        assert!((new / nominal - 1.0).abs() > 1e-4);
    }
}
