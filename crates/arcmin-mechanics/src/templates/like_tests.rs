use super::*;
use crate::checks::{Severity, check_design};
use crate::design::Design;
use crate::templates::{TAO2024, TEMPLATES};

/// Sizes of the series RV-E, RV-C and RV-N in makers' catalogues: name, rated torque in N·m at 15 rpm, a ratio,
/// outer diameter in mm.
const CATALOGUE: [(&str, f64, f64, f64); 22] = [
    ("RV-6E", 58.0, 31.0, 122.0),
    ("RV-20E", 167.0, 105.0, 145.0),
    ("RV-40E", 412.0, 81.0, 190.0),
    ("RV-80E", 784.0, 121.0, 222.0),
    ("RV-110E", 1078.0, 111.0, 244.0),
    ("RV-160E", 1568.0, 145.0, 280.0),
    ("RV-320E", 3136.0, 129.0, 325.0),
    ("RV-450E", 4410.0, 171.0, 370.0),
    ("RV-10C", 98.0, 27.0, 147.0),
    ("RV-27C", 264.6, 36.57, 182.0),
    ("RV-50C", 490.0, 32.54, 222.5),
    ("RV-100C", 980.0, 36.75, 250.5),
    ("RV-200C", 1961.0, 34.86, 347.0),
    ("RV-320C", 3136.0, 35.61, 440.0),
    ("RV-500C", 4900.0, 37.34, 520.0),
    ("RV-25N", 245.0, 81.0, 133.0),
    ("RV-42N", 412.0, 81.0, 159.0),
    ("RV-60N", 600.0, 121.0, 183.0),
    ("RV-80N", 784.0, 105.0, 189.0),
    ("RV-125N", 1225.0, 123.0, 221.0),
    ("RV-160N", 1600.0, 139.0, 249.0),
    ("RV-380N", 3724.0, 129.0, 325.0),
];

fn sheet(torque: f64, ratio: f64, diameter: f64) -> DataSheet {
    DataSheet { ratio, torque, outer_diameter_mm: Some(diameter), ..DataSheet::default() }
}

/// A ratio that is possible with 40 pins, near the required one.
fn feasible(ratio: f64) -> f64 {
    1.0 + 40.0 * ((ratio - 1.0) / 40.0 * 24.0).round() / 24.0
}

/// From every template every size gives a design without error findings, with the required ratio and room for
/// its solids.
#[test]
fn the_series_are_scaled_without_error_findings() {
    for template in TEMPLATES {
        for (name, torque, ratio, diameter) in CATALOGUE {
            let ratio = feasible(ratio);
            let scaled = Scaled::new(template, sheet(torque, ratio, diameter))
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            let tuning = Tuning {
                clearance_um: Some(7.5),
                carrier: Some(300.0),
                preload_um: Some(2.0),
                ..Tuning::default()
            };
            let text = scaled.text(&tuning, &["a note".into()]);
            let design =
                Design::parse(&text, name).unwrap_or_else(|e| panic!("{name}: {e} {:?}\n{text}", e.hint()));
            let machine = design.machine();
            assert!((machine.kinematics().ratio() / ratio - 1.0).abs() < 5e-4, "{name}");
            assert!((machine.rated.torque - torque).abs() < 1e-9);
            assert!((machine.solids.main_rows.preload - 2e-6).abs() < 1e-15);
            let errors: Vec<_> =
                check_design(&design).into_iter().filter(|f| f.severity == Severity::Error).collect();
            assert!(errors.is_empty(), "{name} like {}: {errors:?}", template.name);
            let solid = &machine.solids.housing;
            assert!(2.0 * solid.flange_radius < 1.02e-3 * diameter, "{name}: {solid:?}");
            assert!(
                solid.seat_radius < solid.body_radius && solid.body_radius < solid.flange_radius,
                "{name}"
            );
            let face = solid.bolt_circle_radius + solid.bolt_face_radius;
            assert!(face < solid.flange_radius, "{name}: {solid:?}");
            // Share of rated torque; lost motion is read at 3 %.
            assert!(machine.friction.seal_drag < 0.011 * torque, "{name}: {}", machine.friction.seal_drag);
        }
    }
}

/// Every number of every template has a rule, every rule belongs to a key of the file format, and the file
/// gives the reason for values that are kept.
#[test]
fn every_number_scales_or_has_a_reason() {
    for template in TEMPLATES {
        let numbers = lines(template.text).filter(|line| {
            line.section != "unknowns" && line.key.is_some() && line.value.parse::<f64>().is_ok()
        });
        let scaled = Scaled::new(template, sheet(1000.0, 81.0, 260.0)).unwrap();
        let text = scaled.text(&Tuning::default(), &[]);
        for line in numbers {
            let path = format!("{}.{}", line.section, line.key.unwrap());
            let Some(rule) = rule(&path) else { panic!("{}: no rule for `{path}`", template.name) };
            let written = lines(&text).find(|l| l.section == line.section && l.key == line.key).unwrap();
            match rule {
                Rule::Kept(reason) => {
                    assert!(written.comment.contains(reason), "{path}: {}", written.comment);
                    assert_eq!(written.value, line.value, "{path}");
                }
                Rule::Sheet => {}
                _ => assert!(written.comment.contains("scaled"), "{path}: {}", written.comment),
            }
        }
    }
}

/// Scaled by one, with its own data, the template is unchanged.
#[test]
fn the_template_is_like_itself() {
    let template = TAO2024;
    let scaled = Scaled::new(template, sheet(412.0, 81.0, template.outer_diameter_mm)).unwrap();
    let (old, new) = (
        crate::templates::tao2024(),
        Design::parse(&scaled.text(&Tuning::default(), &[]), "like").unwrap().machine(),
    );
    assert_eq!(scaled.teeth, (18, 36));
    assert_eq!(old.ring, new.ring);
    assert_eq!(old.bearings, new.bearings);
    assert_eq!(old.solids, new.solids);
    assert_eq!(old.friction, new.friction);
    assert_eq!((old.disc.mass, old.disc.inertia), (new.disc.mass, new.disc.inertia));
}

/// Similar machines of twice the size and eight times the torque: every length doubles, stresses and relative
/// gaps are unchanged, ranges of unknowns scale with their keys.
#[test]
fn a_similar_machine_is_similar() {
    for template in TEMPLATES {
        let own = crate::templates::design(template.name).unwrap();
        let old = own.machine();
        let ratio = old.kinematics().ratio();
        let scaled =
            Scaled::new(template, sheet(8.0 * old.rated.torque, ratio, 2.0 * template.outer_diameter_mm))
                .unwrap();
        assert_eq!((scaled.scale, scaled.stretch), (2.0, 1.0));
        let text = scaled.text(&Tuning::default(), &[]);
        let design = Design::parse(&text, "like").unwrap();
        let new = design.machine();
        let pairs = [
            (old.ring.pin_circle_radius, new.ring.pin_circle_radius),
            (old.disc.width, new.disc.width),
            (old.disc.crank_bore_radius, new.disc.crank_bore_radius),
            (old.crankshafts.shaft_diameter, new.crankshafts.shaft_diameter),
            (old.bearings.turning_arm.clearance, new.bearings.turning_arm.clearance),
            (old.solids.carrier.plate_thickness, new.solids.carrier.plate_thickness),
            (old.solids.housing.groove_clearance, new.solids.housing.groove_clearance),
            (old.solids.main_rows.row.pitch_diameter, new.solids.main_rows.row.pitch_diameter),
        ];
        for (a, b) in pairs {
            assert!((b - 2.0 * a).abs() < 2e-6 * a, "{}: {a} {b}", template.name);
        }
        assert!((new.disc.mass / old.disc.mass - 8.0).abs() < 1e-3);
        // The outer diameter is that of the data sheet; ring and flange are similar if those of the template
        // follow the rules.
        let (housing, new) = (&old.solids.housing, &new.solids.housing);
        assert!((2e3 * new.flange_radius / (2.0 * template.outer_diameter_mm) - 1.0).abs() < 5e-3);
        if (2e3 * housing.flange_radius / template.outer_diameter_mm - 1.0).abs() < 5e-3 {
            assert!((new.body_radius / housing.body_radius - 2.0).abs() < 1e-9, "{}", template.name);
        }
        for unknown in design.unknowns() {
            assert!(unknown.covers_nominal(), "{}: {unknown:?}", template.name);
        }
    }
}

/// Thicker crankshafts: bores are the raceways of the rollers, which have 2 % of clearance between them.
#[test]
fn thicker_crankshafts_carry_more_rollers() {
    let scaled = Scaled::new(TEMPLATES[0], sheet(412.0, 81.0, 190.0)).unwrap();
    for factor in [0.8, 1.0, 1.3, 1.7] {
        let tuning = Tuning { crankshafts: factor, ..Tuning::default() };
        let machine = Design::parse(&scaled.text(&tuning, &[]), "like").unwrap().machine();
        let arm = &machine.bearings.turning_arm;
        let eccentric = arm.pitch_diameter - arm.roller_diameter;
        assert!((eccentric - factor * 12e-3).abs() < 1e-6, "{eccentric}");
        assert!(
            (2.0 * machine.disc.crank_bore_radius - arm.pitch_diameter - arm.roller_diameter).abs() < 1e-9
        );
        assert!((eccentric - machine.crankshafts.shaft_diameter - 4e-3).abs() < 1e-6);
        let room = crate::machine::roller_spacing(arm.pitch_diameter, arm.roller_count) - arm.roller_diameter;
        assert!(room > 0.02 * arm.roller_diameter, "{factor}: {room}");
    }
}

#[test]
fn machines_out_of_range_are_not_scaled() {
    let template = TAO2024;
    assert!(matches!(Scaled::new(template, sheet(412.0, 10.0, 190.0)), Err(ScaleError::Range(_))));
    assert!(matches!(Scaled::new(template, sheet(f64::NAN, 81.0, 190.0)), Err(ScaleError::Range(_))));
    assert!(matches!(Scaled::new(template, sheet(412.0, 81.0, 5.0)), Err(ScaleError::Range(_))));
    // 118.5 = 1 + 40 · 47/16.
    assert_eq!(Scaled::new(template, sheet(412.0, 118.5, 190.0)).unwrap().teeth, (16, 47));
    // Three planets of this ratio would touch, two have clearance.
    let many = DataSheet { crankshafts: Some(3.0), ..sheet(412.0, 301.0, 190.0) };
    assert!(matches!(Scaled::new(template, many), Err(ScaleError::Planets { .. })));
    assert!(Scaled::new(template, DataSheet { crankshafts: Some(2.0), ..many }).is_ok());
}
