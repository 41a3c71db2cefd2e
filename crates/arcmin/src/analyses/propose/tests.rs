use super::*;
use crate::analyses::stage::made::MadePlay;
use crate::units::ARCMIN;

fn demand(ratio: f64, torque: f64, outer_diameter_mm: f64, process: Process) -> Demand {
    Demand { ratio, torque, outer_diameter_mm, process, speed_rpm: 600.0 }
}

/// Over ratios, sizes, loads and processes: what is proposed passes its checks; with its gaps the ring pins carry no less
/// than the closed form of equal springs, without gaps that force within 20 %. What is refused says by how much.
#[test]
#[ignore = "long"]
fn a_grid_of_demands_is_met_or_refused() {
    let (mut met, mut refused) = (0, 0);
    for process in Process::VALUES {
        for ratio in [8.0, 11.0, 20.0, 41.0, 59.0] {
            for diameter in [42.0, 80.0, 200.0] {
                for strength in [0.05, 0.5, 2.0] {
                    // N·m that go with the volume.
                    let torque = strength * (diameter / 42.0_f64).powi(3);
                    let demand = demand(ratio, torque, diameter, *process);
                    let fitted = match fit(&demand, &NoHost).unwrap() {
                        Ok(fitted) => fitted,
                        Err(shortfall) => {
                            refused += 1;
                            assert!(shortfall.excess > 1.0, "{demand:?} {shortfall:?}");
                            continue;
                        }
                    };
                    met += 1;
                    let text = fitted.proposal.text(fitted.width_mm, &[]);
                    let design = StageDesign::parse(&text, "grid").unwrap();
                    assert_eq!(design.ratio(), -ratio);
                    for finding in design.findings() {
                        let known = ["eccentric-bearing-life", "softening"].contains(&finding.code);
                        let fine = finding.severity == Severity::Info || known;
                        assert!(fine, "{}: {}\n{text}", finding.code, finding.message);
                    }
                    let over_closed = |design: &StageDesign| {
                        let options = contact::Options::of_positions(24);
                        let found = contact::run(design, &options, &NoHost).unwrap().summary();
                        let number = |key: &str| found.number(key).unwrap();
                        number("max_force_n") / number("closed_form.ring_pin_force_n")
                    };
                    let with_gaps = over_closed(&design);
                    let closed = [
                        "disc.modification.equidistant_offset_um",
                        "output_pins.hole_clearance_um",
                        "bearings.eccentric.clearance_um",
                    ];
                    let without = over_closed(&design.with_all(closed.map(|key| (key, 0.0))).unwrap());
                    assert!(with_gaps > 0.9 && (without - 1.0).abs() < 0.2, "{with_gaps} {without}\n{text}");
                }
            }
        }
    }
    println!("{met} met, {refused} refused");
    assert!(met > 120 && refused > 10, "{met} {refused}");
}

/// Proposed drives jam as rarely as the rule says, by the count of `check`. A gap that was enlarged is not larger than the rule
/// needs: a step less of it lets more drives jam. Drives of steel need no more than the least gaps.
#[test]
#[ignore = "long"]
fn few_proposed_drives_jam() {
    for (process, ratio, torque) in [
        (Process::PrintedFdm, 15.0, 8.0),
        (Process::PrintedSls, 15.0, 2.0),
        (Process::WireEdm, 20.0, 20.0),
        (Process::Ground, 20.0, 20.0),
    ] {
        let fitted = fit(&demand(ratio, torque, 80.0, process), &NoHost).unwrap().ok().unwrap();
        let (gaps, least) = (fitted.proposal.gaps, process.making().gaps);
        let made = |gaps: Gaps| {
            let text = Proposal { gaps, ..fitted.proposal.clone() }.text(fitted.width_mm, &[]);
            MadePlay::of(&StageDesign::parse(&text, "proposed").unwrap()).unwrap()
        };
        let found = made(gaps);
        assert!(
            found.drawn.jam_rate <= JAM_LIMIT && fitted.jam_rate == Some(found.drawn.jam_rate),
            "{process:?}"
        );
        let (before, nominal) = (made(least), found.nominal.unwrap());
        println!(
            "{process:?}: {gaps:?}, {:.1} % jam, nominal play {:.1}′; least gaps {:.1} %, {:.1}′",
            100.0 * found.drawn.jam_rate,
            nominal / ARCMIN,
            100.0 * before.drawn.jam_rate,
            before.nominal.unwrap() / ARCMIN
        );
        if matches!(process, Process::WireEdm | Process::Ground) {
            assert_eq!(gaps, least, "{process:?}");
            continue;
        }
        assert!(before.drawn.jam_rate > JAM_LIMIT && gaps != least, "{process:?}");
        // As the search counts, a gap of the flank is metal off it; cut with a larger pin it opens a little less at the tips.
        let narrower = Gaps { profile_um: gaps.profile_um - 0.1 * least.profile_um, ..gaps };
        assert!(made(narrower).drawn.jam_rate > JAM_LIMIT, "{process:?}");
    }
}

/// The torque that a size is said to reach is reached, and half as much more is not; a refusal names what would do, and it does.
#[test]
#[ignore = "long"]
fn what_is_said_to_do_does() {
    let host = NoHost;
    let asked = demand(20.0, 20.0, 80.0, Process::WireEdm);
    let proposed = propose(asked, &host).unwrap();
    let reach = proposed.notes.last().unwrap();
    let most: f64 = reach.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(most >= asked.torque, "{reach}");
    assert!(fit(&Demand { torque: most, ..asked }, &host).unwrap().is_ok(), "{reach}");
    assert!(fit(&Demand { torque: 1.5 * most, ..asked }, &host).unwrap().is_err(), "{reach}");
    assert!(proposed.notes.iter().all(|note| proposed.text.contains(note)));
    let asked = demand(20.0, 60.0, 80.0, Process::PrintedFdm);
    let error = propose(asked, &host).unwrap_err();
    let help = error.help().unwrap();
    let number = |before: &str, after: &str| -> f64 {
        let rest = help.split(before).nth(1).unwrap();
        rest.split(after).next().unwrap().rsplit(", ").next().unwrap().trim().parse().unwrap()
    };
    let diameter = number("an outer diameter of ", " mm");
    assert!(fit(&Demand { outer_diameter_mm: diameter, ..asked }, &host).unwrap().is_ok(), "{help}");
    let torque = number("mm, ", " N·m");
    assert!(fit(&Demand { torque, ..asked }, &host).unwrap().is_ok(), "{help}");
    assert!(help.contains("--process wire-edm"), "{help}");
    for (wrong, words) in [
        (demand(20.5, 1.0, 80.0, Process::Milled), "not whole"),
        (demand(3.0, 1.0, 80.0, Process::Milled), "a ratio of 3"),
        (demand(20.0, f64::NAN, 80.0, Process::Milled), "a torque"),
        (demand(59.0, 1.0, 42.0, Process::PrintedFdm), "tooth height"),
        (demand(20.0, 0.1, 20.0, Process::WireEdm), "room in the disc"),
    ] {
        let error = propose(wrong, &host).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
