use super::made::HasStageFidelity;
use super::*;
use crate::analyses::NoHost;
use crate::checks::Severity;
use crate::design::Design;
use crate::machine::{GapChain, OverlapPlace, StageErrors};
use crate::templates::{NEMA17_19, RV_40E};
use crate::units::UM;

pub(super) fn design(changes: &[(&str, &str)]) -> StageDesign {
    let text = changes.iter().fold(NEMA17_19.text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    StageDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

pub(super) fn number(outcome: &dyn Outcome, key: &str) -> f64 {
    outcome.summary().number(key).unwrap_or_else(|| panic!("{key}"))
}

pub(super) fn bench(design: &StageDesign) -> rig::Rig {
    rig::run(design, &rig::Options::parse("", "test").unwrap(), &NoHost).unwrap()
}

#[test]
fn the_shipped_stage_is_sound() {
    let design = design(&[]);
    assert_eq!(design.ratio(), -19.0);
    for finding in design.findings() {
        assert_eq!(finding.severity, Severity::Info, "{}", finding.message);
    }
}

/// Static equilibria at no load against the chain of single gaps: at least their sum, at most a fifth more (the pins in their
/// holes by 1/cos(π/z_w), and the displacement of a disc along its eccentric).
#[test]
#[ignore = "long"]
fn play_is_at_least_the_chain() {
    for count in ["count = 6 ", "count = 8 ", "count = 5 "] {
        let design = design(&[("count = 6\n", &format!("{count}\n"))]);
        let rig = bench(&design);
        let total = design.play_chain().total();
        assert!(rig.play[0] > 0.999 * total && rig.play[1] < 1.2 * total, "{:?} {total}", rig.play);
        assert!(rig.figures.lost_motion > rig.play[0], "{:?}", rig.figures);
    }
}

/// With the output at rest the discs do not turn, and the play of the ring is 2Δ/(e z_p).
#[test]
#[ignore = "long"]
fn a_driven_housing_has_the_play_and_stiffness_of_its_ring() {
    let tight =
        [("hole_clearance_um = 10 ", "hole_clearance_um = 0 "), ("clearance_um = 6\n", "clearance_um = 0\n")];
    let output_at_rest = ("fixed_member = \"ring\" ", "fixed_member = \"output\" ");
    let driven = design(&[tight[0], tight[1], output_at_rest]);
    assert_eq!(driven.ratio(), 20.0);
    let closed = 2.0 * 10e-6 / (0.5e-3 * 20.0);
    assert!((driven.play_chain().total() / closed - 1.0).abs() < 1e-3, "{:?}", driven.play_chain());
    // A torque at the ring is 19/20 of that at the pins, an angle of the pins 19/20 of that of the ring. The stiffness is
    // therefore larger by (20/19)² if forces are proportional to the torque.
    let linear = [
        tight[0],
        tight[1],
        ("equidistant_offset_um = 10 ", "equidistant_offset_um = 0 "),
        ("[drive]", "[contact]\nlaw = \"linear\"\nstiffness_n_per_um = 20\n[drive]"),
        ("kind = \"ball\"", "kind = \"cylindrical\"\nroller_length_mm = 4"),
    ];
    let at_rest = [linear[0], linear[1], linear[2], linear[3], linear[4], output_at_rest];
    let [one, other] = [design(&linear), design(&at_rest)].map(|design| bench(&design).figures.stiffness);
    assert!((other / one / (20.0_f64 / 19.0).powi(2) - 1.0).abs() < 0.005, "{one} {other}");
}

/// Without gaps, forces are near the closed forms of equal springs, and the work at the input equals that at the output.
#[test]
fn forces_are_near_the_closed_forms_without_gaps() {
    let design = design(&[
        ("hole_clearance_um = 10 ", "hole_clearance_um = 0 "),
        ("clearance_um = 6\n", "clearance_um = 0\n"),
        ("equidistant_offset_um = 10 ", "equidistant_offset_um = 0 "),
        ("[drive]", "[contact]\nlaw = \"linear\"\nstiffness_n_per_um = 20\n[drive]"),
    ]);
    let contact =
        contact::run(&design, &contact::Options::parse("positions = 60", "test").unwrap(), &NoHost).unwrap();
    for (found, closed, within) in [
        ("max_force_n", "closed_form.ring_pin_force_n", 0.25),
        ("max_output_pin_force_n", "closed_form.output_pin_force_n", 0.35),
        ("eccentric_bearing_force_n", "closed_form.eccentric_bearing_force_n", 0.25),
    ] {
        let (found, closed) = (number(&contact, found), number(&contact, closed));
        assert!((found / closed - 1.0).abs() < within, "{found} {closed}");
    }
}

#[test]
fn rolling_elements_carry_the_force_of_their_eccentric() {
    series_tests::rollers_add_up(&AnyDesign::Eccentric(Box::new(design(&[]))), 24, "rigid");
}

/// Rollers in place of sliding pins lose by the ratio of the radii, and a drive without friction nothing.
#[test]
#[ignore = "long"]
fn losses_are_forces_times_sliding_distances() {
    let friction = |pin: f64, ring: f64| {
        format!(
            "[friction]\nflank_coefficient = {ring}\npin_seat_coefficient = {pin}\nbearing_coefficient = 0\n[drive]"
        )
    };
    let with = |pin: f64, ring: f64| bench(&design(&[("[drive]", friction(pin, ring).as_str())]));
    assert_eq!(with(0.0, 0.0).efficiency.forward, 1.0);
    // Holes move on the pins by e (1 + 1/z_c) a radian of the input, rollers slide by 1.5/2 of that on their pins. Forces of
    // all pins on a disc add up to 4 T/(π R_w) with equal springs; with a gap fewer carry, nearer to the full lever: T/R_w.
    let rolling = with(0.1, 0.0);
    let way = 0.5e-3 * (1.0 + 1.0 / 19.0) * 0.75;
    let [least, most] = [1.0, 4.0 / std::f64::consts::PI].map(|sum| 0.1 * way * sum * 3.0 / 10.5e-3);
    assert!(
        rolling.losses[0].total() > 0.98 * least && rolling.losses[0].total() < 1.02 * most,
        "{:?}",
        rolling.losses
    );
    assert!((rolling.efficiency.forward - 3.0 / (3.0 + 19.0 * rolling.losses[0].output)).abs() < 1e-12);
    let sliding = bench(&design(&[
        ("[drive]", friction(0.0, 0.1).as_str()),
        ("roller_radius_mm = 2 ", "roller_radius_mm = 1.5 "),
    ]));
    assert!(sliding.losses[0].output > 1.2 * rolling.losses[0].output, "{:?}", sliding.losses);
}

#[test]
fn what_cannot_be_is_refused_at_its_key() {
    for (from, to, key) in [
        ("eccentricity_mm = 0.5", "eccentricity_mm = 0.9", "eccentric.eccentricity_mm"),
        ("roller_radius_mm = 2 ", "roller_radius_mm = 1 ", "output_pins.roller_radius_mm"),
        ("count = 2\n", "count = 2\nlobe_count = 18\n", "disc.lobe_count"),
        ("count = 2\n", "count = 2\ncentre_hole_diameter_mm = 3\n", "disc.centre_hole_diameter_mm"),
        ("count = 2\n", "count = 2\nwindow_rim_mm = 3\n", "disc.window_rim_mm"),
        ("circle_radius_mm = 10.5", "circle_radius_mm = 13", "output_pins.circle_radius_mm"),
        ("circle_radius_mm = 10.5", "circle_radius_mm = 9", "output_pins.circle_radius_mm"),
    ] {
        let error = StageDesign::parse(&NEMA17_19.text.replacen(from, to, 1), "test.toml").unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
    }
    for (from, to, code, severity) in [
        ("circle_radius_mm = 10.5", "circle_radius_mm = 12", "rim-thickness", Severity::Warning),
        ("circle_radius_mm = 10.5", "circle_radius_mm = 9.1", "bore-ligament", Severity::Warning),
        ("[drive]", "[friction]\nseal_drag_n_m = 0.1\n[drive]", "unused-keys", Severity::Warning),
        ("pin_radius_mm = 1.5                  #", "pin_radius_mm = 2.7 #", "pin-overlap", Severity::Error),
        ("equidistant_offset_um = 10 ", "equidistant_offset_um = -5 ", "interference", Severity::Warning),
        ("rated_torque_n_m = 3", "rated_torque_n_m = 60", "contact-pressure", Severity::Error),
        ("input_speed_rpm = 600", "input_speed_rpm = 6000", "eccentric-bearing-life", Severity::Warning),
        ("count = 2\n", "count = 1\n", "eccentric-balance", Severity::Warning),
    ] {
        let findings = design(&[(from, to)]).findings();
        let found = findings.iter().find(|finding| finding.code == code).unwrap();
        assert_eq!(found.severity, severity, "{}", found.message);
        assert!(!found.message.contains("one eccentric") || !found.message.contains("couple"));
    }
}

#[test]
fn families_are_distinguished() {
    assert!(matches!(AnyDesign::parse(NEMA17_19.text, "a").unwrap(), AnyDesign::Eccentric(_)));
    let error = Design::parse(NEMA17_19.text, "a").unwrap_err();
    assert_eq!(error.key(), Some("drive.family"));
    let named = format!("{}\n[drive]\nfamily = \"rv\"\n", RV_40E.text);
    let AnyDesign::Rv(rv) = AnyDesign::parse(&named, "a").unwrap() else { panic!() };
    assert_eq!(rv.hash(), Design::parse(RV_40E.text, "a").unwrap().hash());
    let study = super::super::by_name("tao2024").unwrap();
    let design = AnyDesign::parse(NEMA17_19.text, "a").unwrap();
    assert!(design.run(study, "", "test", &NoHost).unwrap_err().to_string().contains("RV reducers only"));
}

/// Keys of a single stage are read and set as those of an RV reducer. Comments are kept. The family cannot be changed.
#[test]
fn a_stage_is_changed_by_its_keys() {
    let any = AnyDesign::parse(NEMA17_19.text, "a.toml").unwrap();
    assert_eq!(any.get("eccentric.eccentricity_mm").unwrap(), 0.5.into());
    assert_eq!(any.text(), NEMA17_19.text);
    let other = any.with("eccentric.eccentricity_mm", 0.55).unwrap();
    assert!(other.text().contains("eccentricity_mm = 0.55") && other.text().contains("# dowel pins of 3 mm"));
    assert!(other != any && other.hash() != any.hash());
    assert_eq!(other.with("eccentric.eccentricity_mm", 0.5).unwrap().hash(), any.hash());
    assert_eq!(AnyDesign::parse(other.text(), "b").unwrap().hash(), other.hash());
    let error = any.with("eccentric.eccentricty_mm", 0.5).unwrap_err();
    assert_eq!(error.hint(), Some("did you mean `eccentric.eccentricity_mm`?"));
    let error = any.with("eccentric.eccentricity_mm", 0.9).unwrap_err();
    assert_eq!((error.key(), error.file_name.as_str()), (Some("eccentric.eccentricity_mm"), "a.toml"));
    assert!(error.line().is_some());
    assert!(any.with("drive.family", "rv").unwrap_err().to_string().contains("eccentric"));
    let rv = AnyDesign::parse(RV_40E.text, "b").unwrap();
    assert!(rv.with("drive.family", "eccentric").unwrap_err().to_string().contains("single stage"));
    assert!(any.keys().iter().any(|entry| entry.path == "output_pins.support"));
    assert!(any.keys().iter().all(|entry| !entry.path.starts_with("crankshafts")));
}

const TOLERANCES: &str = "\n[tolerances]\npin_position_um = 3\npin_circle_radius_um = 6\nflank_offset_um = 3\nflank_run_out_um = 3\n\
                          eccentricity_um = 2\neccentric_clearance_um = 3\nbore_diameter_um = 4\nbore_position_um = 3\n";

fn toleranced(more: &str) -> StageDesign {
    let text = format!("{}{TOLERANCES}{more}", NEMA17_19.text);
    StageDesign::parse(&text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn rig_of(design: &StageDesign, options: &str) -> rig::Rig {
    let options = format!("positions = 3\nte_positions = 12\n{options}");
    rig::run(design, &rig::Options::parse(&options, "test").unwrap(), &NoHost).unwrap()
}

/// Equal seeds give equal drives, on the bench and under load. The play by gaps is at most that of static equilibria at some
/// positions.
#[test]
#[ignore = "long"]
fn drawn_stages_are_computed() {
    let design = toleranced("");
    let one = rig_of(&design, "errors = \"drawn\"\nseed = 7");
    let again = rig_of(&design, "errors = \"drawn\"\nseed = 7");
    assert_eq!(one.summary().to_json(), again.summary().to_json());
    let plays: Vec<f64> = (1..6)
        .map(|seed| {
            let rig = rig_of(&design, &format!("errors = \"drawn\"\nseed = {seed}"));
            let gaps = rig.gap_play.unwrap();
            assert!(gaps < 1.02 * rig.play[0] && gaps > 0.7 * rig.play[0], "{gaps} {:?}", rig.play);
            gaps
        })
        .collect();
    assert!(plays.windows(2).all(|pair| pair[0] != pair[1]), "{plays:?}");
    let nominal = rig_of(&design, "errors = \"none\"");
    assert_eq!(nominal.play, rig_of(&design, "").play);
    // With a share of 1 drives of one batch have all errors in common.
    let batch = |seed: usize| {
        let options =
            format!("errors = \"drawn\"\nseed = {seed}\nbatch_seed = 3\nbatch_share = 1.0\nte_positions = 8");
        rig::run(&design, &rig::Options::parse(&options, "test").unwrap(), &NoHost).unwrap().gap_play
    };
    assert_eq!(batch(1), batch(2));
    let contact = |options: &str| {
        let options = contact::Options::parse(&format!("positions = 8\n{options}"), "test").unwrap();
        contact::run(&design, &options, &NoHost)
    };
    let (drawn, nominal) = (contact("errors = \"drawn\"").unwrap(), contact("").unwrap());
    assert!(number(&drawn, "max_force_n") != number(&nominal, "max_force_n"));
    for options in ["errors = \"given\"", "seed = 3"] {
        assert!(contact(options).is_err(), "{options}");
    }
}

/// Thinner pins increase the play like a deeper cut of the flank; a thicker pin jams; parts that do not exist are refused.
#[test]
#[ignore = "long"]
fn given_errors_of_stages_are_taken() {
    let thin = toleranced("[errors]\npin_radius_um = -5\n");
    let deep = design(&[("equidistant_offset_um = 10 ", "equidistant_offset_um = 15 ")]);
    let (one, other) = (rig_of(&thin, ""), rig_of(&deep, ""));
    assert!((one.play[0] / other.play[0] - 1.0).abs() < 2e-3, "{:?} {:?}", one.play, other.play);
    assert_eq!(one.summary().to_json()["errors"]["source"], "given");
    let thick = toleranced("[[errors.pins]]\npin = 4\nradius_um = 60\n");
    let jammed = rig_of(&thick, "");
    assert!(jammed.gap_play.is_none());
    // One pin is 60 µm too thick, with gaps of 10 µm: the drive turns if the flank is cut so deep that the disc can avoid
    // the pin; larger holes have no effect.
    let overlap = jammed.overlap.unwrap();
    assert!(overlap.place == OverlapPlace::Ring, "{overlap:?}");
    assert!(overlap.depth > 5e-6 && overlap.depth < 50e-6, "{overlap:?}");
    let hole = toleranced("[[errors.holes]]\ndisc = 2\npin = 3\ndiameter_um = -24\n");
    let play = |options: &str| rig_of(&hole, options).gap_play.unwrap();
    assert!(play("errors = \"given\"") < 0.9 * play("errors = \"none\""));
    for (section, key) in [
        ("[[errors.holes]]\ndisc = 3\npin = 1\n", "errors.holes[0].disc"),
        ("[[errors.output_pins]]\npin = 7\n", "errors.output_pins[0].pin"),
        ("[[errors.eccentrics]]\ndisc = 1\n[[errors.eccentrics]]\ndisc = 1\n", "errors.eccentrics[1].disc"),
        ("[errors]\nsun_run_out_um = 1\n", "errors.sun_run_out_um"),
    ] {
        let error = StageDesign::parse(&format!("{}{section}", NEMA17_19.text), "test.toml").unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
    }
}

/// A thousand drawn chains within their time; the mean of an exact series is the nominal play, a single tolerance has all the
/// variance, and selection of the pins by size removes it.
#[test]
fn play_as_made_is_drawn() {
    let started = std::time::Instant::now();
    let made = made::MadePlay::of(&toleranced("")).unwrap();
    assert!(started.elapsed().as_secs_f64() < 5.0, "{:?}", started.elapsed());
    let [low, mean, high] =
        [made.drawn.quantile(0.05), made.drawn.mean(), made.drawn.quantile(0.95)].map(Option::unwrap);
    assert!(low < mean && mean < high && made.drawn.jam_rate < 0.05);
    // Extremes of many pins: the least play is below the nominal one.
    assert!(mean < made.nominal.unwrap());
    assert!(made.matched[0].variance_share > 0.3, "{}", made.matched[0].variance_share);
    let only = |line: &str| {
        let text = format!("{}\n[tolerances]\n{line}\n", NEMA17_19.text);
        made::MadePlay::of(&StageDesign::parse(&text, "test.toml").unwrap()).unwrap()
    };
    let exact = only("");
    assert!((exact.drawn.mean().unwrap() / exact.nominal.unwrap() - 1.0).abs() < 1e-12);
    assert!(exact.tolerances.is_empty());
    let depth = only("flank_offset_um = 6");
    assert_eq!(depth.tolerances[0].key, "flank_offset_um");
    assert!((depth.tolerances[0].variance_share - 1.0).abs() < 1e-9);
    // A depth h of the flank gives 2 h/(e z_c): ±2 µm of standard deviation.
    let design = toleranced("");
    let lever = design.drive().profile.eccentricity * design.drive().profile.lobe_count() as f64;
    let spread = (depth.drawn.quantile(0.95).unwrap() - depth.drawn.quantile(0.05).unwrap()) * lever / 2.0;
    assert!((spread / (2.0 * 1.645 * 2e-6) - 1.0).abs() < 0.1, "{spread}");
    assert!(depth.matched[0].variance_share > 0.95);
    let coarse = only("pin_radius_um = 40");
    assert!(coarse.drawn.jam_rate > 0.1);
    // Pins that are all too thick by h overlap by h less the gap of 10 µm; output pins press along the eccentric, where its
    // bearing gives way by 3 µm.
    let chain = GapChain::new(design.drive());
    for (ring, output, depth, place) in [
        (25.0, 0.0, 15.0, OverlapPlace::Ring),
        (0.0, 22.0, 9.0, OverlapPlace::Output),
        (25.0, 22.0, 15.0, OverlapPlace::Both),
    ] {
        let errors =
            StageErrors { pin_radius: ring * UM, output_pin_radius: output * UM, ..StageErrors::default() };
        let overlap = chain.overlap(&[errors]).unwrap();
        assert!((overlap.depth / (depth * UM) - 1.0).abs() < 0.02 && overlap.place == place, "{overlap:?}");
    }
    assert!(chain.overlap(&[StageErrors::default()]).is_none());
    let [median, high] = [0.5, 0.95].map(|share| coarse.overlaps.quantile(share).unwrap());
    assert!(0.0 < median && median < high && high < 100e-6, "{median} {high}");
    assert_eq!(coarse.overlaps.place().unwrap().0, OverlapPlace::Ring);
    assert!(coarse.finding().message.contains("at the ring pins"), "{}", coarse.finding().message);
    assert!(exact.overlaps.quantile(0.5).is_none() && !exact.finding().message.contains("overlap"));
}

/// Random drives with all gaps open: every static equilibrium is found, and the play is at least the chain.
#[test]
#[ignore = "long"]
fn random_stages_have_results() {
    random_stages(7, 60, 1);
}

pub(super) fn random_stages(seed: u64, count: usize, difference: usize) {
    let mut random = uniform(seed);
    let mut tried = 0;
    while tried < count {
        let mut between = |low: f64, high: f64| low + (high - low) * random();
        let pins = between(8.0 * difference as f64, 45.0 + 10.0 * (difference - 1) as f64) as usize;
        let circle = between(12.0, 120.0);
        let k1 = between(0.4, 0.8);
        let eccentricity = k1 * difference as f64 * circle / pins as f64;
        let room = circle * (std::f64::consts::PI / pins as f64).sin();
        let pin_radius = room * between(0.3, 0.6);
        let (roller, holes) = (between(0.04, 0.08) * circle, between(4.0, 9.0) as usize);
        let text = NEMA17_19
            .text
            .replace("pin_count = 20 ", &format!("pin_count = {pins} "))
            .replace("pin_circle_radius_mm = 17", &format!("pin_circle_radius_mm = {circle}"))
            .replacen("pin_radius_mm = 1.5 ", &format!("pin_radius_mm = {pin_radius} "), 1)
            .replace("count = 2\n", &format!("count = {}\n", between(1.0, 3.99) as usize))
            .replace("eccentricity_mm = 0.5", &format!("eccentricity_mm = {eccentricity}"))
            .replace("count = 6\n", &format!("count = {holes}\n"))
            .replace("circle_radius_mm = 10.5", &format!("circle_radius_mm = {}", 0.6 * circle))
            .replace("roller_radius_mm = 2 ", &format!("roller_radius_mm = {roller} "))
            .replacen("\npin_radius_mm = 1.5\n", &format!("\npin_radius_mm = {}\n", 0.7 * roller), 1)
            .replace("hole_clearance_um = 10 ", &format!("hole_clearance_um = {} ", between(0.0, 60.0)))
            .replace("clearance_um = 6\n", &format!("clearance_um = {}\n", between(0.0, 30.0)))
            .replace(
                "equidistant_offset_um = 10 ",
                &format!("equidistant_offset_um = {} ", between(0.0, 60.0)),
            )
            .replace("crank_bore_diameter_mm = 13 ", "")
            .replace(
                "rated_torque_n_m = 3",
                &format!("rated_torque_n_m = {}", between(0.2, 3.0) * (circle / 17.0).powi(3)),
            );
        let text = match difference {
            1 => text,
            _ => {
                let rest = if between(0.0, 1.0) < 0.3 { "output" } else { "ring" };
                let text = text.replace("fixed_member = \"ring\" ", &format!("fixed_member = \"{rest}\" "));
                text.replace("[ring]", &format!("[ring]\ntooth_difference = {difference}"))
            }
        };
        let Ok(design) = StageDesign::parse(&text, "random.toml") else { continue };
        assert_eq!(design.drive().profile.tooth_difference, difference);
        if design.findings().iter().any(|finding| finding.severity == Severity::Error) {
            continue;
        }
        tried += 1;
        let any = AnyDesign::Eccentric(Box::new(design.clone()));
        series_tests::answered(&any);
        if tried % 5 == 0 {
            series_tests::answered_with_elastic_discs(&any);
            series_tests::moves(&any, if tried % 10 == 0 { "elastic" } else { "rigid" });
        }
        if tried % 30 == 0 {
            let short = design.with_all([("limits.service_life_h", 20.0)]).unwrap();
            let options = life::Options::parse("points = 4", "test").unwrap();
            let life =
                life::run(&short, &options, &NoHost).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
            assert!(life.fidelity().elastic_discs && life.last().accuracy.max_depth >= 0.0, "{text}");
        }
        if tried % 10 == 0 {
            let options = life::Options::parse("points = 4\ndiscs = \"rigid\"", "test").unwrap();
            let life =
                life::run(&design, &options, &NoHost).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
            assert!(
                life.last().accuracy.max_depth >= 0.0 && life.summary().number("ratio").is_some(),
                "{text}"
            );
        }
    }
}

/// Numbers in 0..1 by xorshift.
pub(super) fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}
