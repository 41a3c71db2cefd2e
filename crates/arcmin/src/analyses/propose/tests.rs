use super::*;

fn demand(ratio: f64, torque: f64, outer_diameter_mm: f64, process: Process) -> Demand {
    Demand { ratio, torque, outer_diameter_mm, process, speed_rpm: 600.0 }
}

/// Over ratios, sizes and processes: what is proposed passes its checks, its ring pins carry at least what they would as
/// equal springs, and no more than one pin alone; what is refused says by how much.
#[test]
fn a_grid_of_demands_is_met_or_refused() {
    let (mut met, mut refused) = (0, 0);
    for process in Process::VALUES {
        for ratio in [8.0, 11.0, 15.0, 20.0, 29.0, 41.0, 59.0] {
            for diameter in [42.0, 80.0, 120.0, 200.0] {
                for strength in [0.02, 0.2, 2.0] {
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
                    for finding in findings(&design) {
                        let known = ["unused-keys", "eccentric-bearing-life"].contains(&finding.code);
                        assert!(
                            finding.severity == Severity::Info || known,
                            "{}: {}\n{text}",
                            finding.code,
                            finding.message
                        );
                    }
                    let options = contact::Options { torque_nm: None, positions: 36 };
                    let found = contact::run(&design, &options, &NoHost).unwrap().summary();
                    let number = |key: &str| found.number(key).unwrap();
                    let [force, closed] = ["max_force_n", "closed_form.ring_pin_force_n"].map(number);
                    let alone = closed * 0.25 * (ratio + 1.0);
                    println!(
                        "{} {ratio} {diameter} {torque:.2}: width {} force {:.2} of closed, {:.2} of one",
                        process.word(),
                        fitted.width_mm,
                        force / closed,
                        force / alone
                    );
                    assert!(force > 0.9 * closed && force < 2.0 * alone, "{force} {closed} {alone}\n{text}");
                }
            }
        }
    }
    println!("{met} met, {refused} refused");
    assert!(met > 200 && refused > 20, "{met} {refused}");
}
