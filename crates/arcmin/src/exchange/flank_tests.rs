use super::*;
use crate::geometry::{FlankDirection, FlankError, FlankHarmonic, Relief, Vec2, turned, unit};
use crate::machine::Machine;
use crate::templates::tao2024;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

/// An export of a machine's flank in the form of a measuring machine's output: with an error, displaced and
/// rotated, with noise, in any order, as ball centres.
struct Measurement {
    error: FlankError,
    noise: f64,
    centre: Vec2,
    rotation: f64,
    probe: f64,
    outliers: usize,
}

impl Measurement {
    fn points(&self, machine: &Machine, seed: u64) -> Vec<[f64; 4]> {
        let design = crate::design::Design::parse(crate::templates::TAO2024.text, "t").unwrap();
        let options = ProfileOptions { tolerance: 2e-6, ..ProfileOptions::default() };
        let export = ProfileExport::new(machine, Stamp::of(&design), options).unwrap();
        let set = read_points(export.csv().as_bytes(), "profile.csv").unwrap();
        let outline = export.outline();
        let table = outline.table();
        let mut random = Pcg64::seed_from_u64(seed);
        let normal = Normal::new(0.0, self.noise).unwrap();
        let mut points: Vec<[f64; 4]> = set
            .points
            .iter()
            .zip(set.normals.as_ref().unwrap())
            .map(|(place, n)| {
                let (off, tau) = outline.distance(*place, &table);
                assert!(off.abs() < 1e-11);
                let depth = self.error.depth(tau, *n) + normal.sample(&mut random);
                let moved = turned(place + (self.probe - depth) * n, unit(self.rotation)) + self.centre;
                let n = turned(*n, unit(self.rotation));
                [moved.x, moved.y, n.x, n.y]
            })
            .collect();
        for i in (1..points.len()).rev() {
            points.swap(i, random.random_range(0..=i));
        }
        for i in 0..self.outliers {
            let at = i * points.len() / self.outliers;
            points[at][0] += 2e-4;
            points[at][1] += 3e-4;
        }
        points
    }
}

fn plain() -> Measurement {
    Measurement {
        error: FlankError::default(),
        noise: 1e-6,
        centre: Vec2::new(0.0123, -0.0456),
        rotation: 0.05,
        probe: 0.0,
        outliers: 0,
    }
}

fn as_table(points: &[[f64; 4]]) -> String {
    let mut text = String::from("nr;y [mm];x [mm]\n");
    for (i, [x, y, ..]) in points.iter().enumerate() {
        text += &format!("P{i};{};{}\n", y * 1e3, x * 1e3).replace('.', ",");
    }
    text
}

fn as_list(points: &[[f64; 4]]) -> String {
    let line = |[x, y, i, j]: &[f64; 4]| format!("{}\t{}\t-4.5\t{i}\t{j}\t0\r\n", x * 1e3, y * 1e3);
    "XYZIJK METRIC\r\n".to_owned() + &points.iter().map(line).collect::<String>()
}

/// VDA-FS with 72 columns and a line number.
fn as_vda(points: &[[f64; 4]]) -> String {
    let mut lines = vec!["DISC = HEADER / 2".to_owned(), "any = words / here".into(), "$$ and here".into()];
    lines.push(format!("M1 = MDI / {},", points.len()));
    for [x, y, i, j] in points {
        lines.push(format!("{:.7},{:.7},-4.5,", x * 1e3, y * 1e3));
        lines.push(format!("{i:.7},{j:.7},0.0D+00,"));
    }
    lines.push("DISC = END".into());
    lines.iter().enumerate().map(|(n, line)| format!("{line:<72}{:>8}\n", n + 1)).collect()
}

fn options(target: FlankTarget) -> FlankImportOptions {
    FlankImportOptions { target, probe_radius: 0.0, origin_is_axis: false }
}

fn measured() -> FlankTarget {
    FlankTarget::MeasuredFlank { disc: 0, file: "disc-1.csv".into() }
}

/// All formats, any order and position, with a ball and outliers: the pose is recovered within the noise.
#[test]
fn pose_is_found_in_every_format() {
    let machine = tao2024();
    let measurement = Measurement { probe: 1e-3, outliers: 12, ..plain() };
    let points = measurement.points(&machine, 1);
    let pitch = std::f64::consts::TAU / 39.0;
    let expected = measurement.rotation - (measurement.rotation / pitch).round() * pitch;
    for text in [as_table(&points), as_list(&points), as_vda(&points)] {
        let options = FlankImportOptions { probe_radius: 1e-3, ..options(measured()) };
        let import = import_flank(&machine, text.as_bytes(), "points", &options).unwrap();
        let fit = &import.fit;
        // 1 µm over about 3000 points: 0.02 µm times the root of the information of one point about each
        // unknown.
        assert!((fit.centre - measurement.centre).norm() < 0.15e-6, "{:?}", fit.centre);
        assert!((fit.rotation - expected).abs() * 0.061 < 0.15e-6, "{}", fit.rotation);
        assert!(fit.offset.abs() < 0.1e-6 && (fit.deviation - 1e-6).abs() < 0.1e-6, "{:e}", fit.deviation);
        assert!((10..=14).contains(&fit.outliers.len()), "{}", fit.outliers.len());
        assert!(fit.outliers.iter().filter(|o| o.distance.abs() > 5e-5).count() >= 10);
        assert!(import.split.rest < 1.1e-6);
        assert_eq!(import.plots.len(), 3);
    }
}

/// A flank written as measured is read back with the original error.
#[test]
fn measured_flank_round_trip() {
    let machine = tao2024();
    let harmonic = |order, amplitude, phase, direction| FlankHarmonic { order, amplitude, phase, direction };
    let error = FlankError {
        harmonics: vec![
            harmonic(2, 4e-6, 0.3, FlankDirection::Inwards),
            harmonic(3, 3e-6, -0.2, FlankDirection::Around),
            // The other phase would be a rotation, which the fit removes.
            harmonic(39, 2e-6, 0.0, FlankDirection::Normal),
        ],
        measured: None,
    };
    let measurement = Measurement { error: error.clone(), noise: 0.5e-6, rotation: 0.03, ..plain() };
    let points = measurement.points(&machine, 2);
    let import = import_flank(&machine, as_list(&points).as_bytes(), "points", &options(measured())).unwrap();
    let csv = import.csv.unwrap();
    let form = crate::tables::Form::new(&[
        crate::tables::Column::number("angle_deg").rising(),
        crate::tables::Column::number("depth_um"),
    ]);
    let table = form.read(csv.as_bytes(), "disc-1.csv").unwrap();
    let pairs: Vec<(f64, f64)> = table
        .numbers("angle_deg")
        .unwrap()
        .iter()
        .zip(table.numbers("depth_um").unwrap())
        .map(|(angle, depth)| (angle.to_radians(), depth * 1e-6))
        .collect();
    let back = FlankError::from_measured(&pairs, 39).unwrap();
    let profile = machine.profile();
    let mut square = 0.0;
    for i in 0..2000 {
        let tau = std::f64::consts::TAU * f64::from(i) / 2000.0;
        let n = profile.outward_normal(tau);
        square += (back.depth(tau, n) - error.depth(tau, n)).powi(2);
    }
    // The density of the points is that of the reader's grid, so that the noise is not reduced.
    assert!((square / 2000.0).sqrt() < 0.6e-6, "{:e}", (square / 2000.0).sqrt());

    let import = import_flank(
        &machine,
        as_list(&points).as_bytes(),
        "points",
        &options(FlankTarget::Harmonics { disc: 1 }),
    )
    .unwrap();
    for (order, amplitude, phase, direction) in
        [(2, 4e-6, 0.3, FlankDirection::Inwards), (3, 3e-6, -0.2, FlankDirection::Around)]
    {
        let found =
            import.split.harmonics.iter().find(|h| h.order == order && h.direction == direction).unwrap();
        let off = found.amplitude * unit(order as f64 * found.phase) - amplitude * unit(order as f64 * phase);
        assert!(off.norm() < 0.1e-6, "{found:?}");
    }
    assert!((import.split.common_depth(0.7) - 2e-6 * 0.7_f64.cos()).abs() < 0.15e-6);
    let text = crate::templates::TAO2024.text.to_owned() + &import.toml;
    let design = crate::design::Design::parse(&text, "t").unwrap();
    assert!(design.given_errors().unwrap().discs[1].flank.harmonics.len() >= 2);
}

/// With the file's origin as the axis, an eccentric disc has a run-out of the first order.
#[test]
fn run_out_against_the_axis() {
    let machine = tao2024();
    let measurement = Measurement { centre: Vec2::new(6e-6, 8e-6), rotation: 0.0, noise: 0.3e-6, ..plain() };
    let text = as_table(&measurement.points(&machine, 3));
    let axis = FlankImportOptions { origin_is_axis: true, ..options(FlankTarget::Harmonics { disc: 0 }) };
    let import = import_flank(&machine, text.as_bytes(), "points", &axis).unwrap();
    let first = |direction| {
        import.split.harmonics.iter().find(|h| h.order == 1 && h.direction == direction).unwrap().amplitude
    };
    assert!((first(FlankDirection::Inwards) - 1e-5).abs() < 0.1e-6);
    let (_, _, run_out) = import.split.pitch_and_run_out();
    assert!((run_out - 2e-5).abs() < 0.6e-6, "{run_out:e}");
    let free = import_flank(&machine, text.as_bytes(), "points", &options(measured())).unwrap();
    assert!((free.fit.centre.norm() - 1e-5).abs() < 0.1e-6);
}

/// The modification of a ground flank is recovered as keys of the design.
#[test]
fn modification_round_trip() {
    let mut machine = tao2024();
    machine.disc.modification.equidistant_offset = 12e-6;
    machine.disc.modification.radial_offset = -20e-6;
    machine.disc.modification.rotation = 1e-4;
    let text = as_table(&plain().points(&machine, 4));
    let import =
        import_flank(&tao2024(), text.as_bytes(), "points", &options(FlankTarget::Modification)).unwrap();
    let keys = import.toml.replace("[disc.modification]", "");
    let parsed: toml::Table = keys.parse().unwrap();
    let value =
        |key: &str| parsed[key].as_float().unwrap_or_else(|| parsed[key].as_integer().unwrap() as f64);
    // 1 µm over 2400 points is 0.02 µm; the correlation of the three parameters multiplies it by up to a
    // hundred, and a radial offset of 20 µm also changes the inclination of the normals slightly.
    assert!((value("equidistant_offset_um") - 12.0).abs() < 2.5, "{keys}");
    assert!((value("radial_offset_um") + 20.0).abs() < 3.0, "{keys}");
    assert!((value("rotation_arcmin") - 1e-4_f64.to_degrees() * 60.0).abs() < 0.1, "{keys}");
    // Independent of the keys, the flank that they describe is the measured one.
    let mut back = tao2024();
    back.disc.modification.equidistant_offset = value("equidistant_offset_um") * 1e-6;
    back.disc.modification.radial_offset = value("radial_offset_um") * 1e-6;
    back.disc.modification.rotation = value("rotation_arcmin") / 60.0_f64 * crate::units::DEG;
    if let Some(pairs) = parsed.get("free_form_deg_um") {
        let number =
            |value: &toml::Value| value.as_float().unwrap_or_else(|| value.as_integer().unwrap() as f64);
        let free: Vec<[f64; 2]> = pairs
            .as_array()
            .unwrap()
            .iter()
            .map(|pair| [number(&pair[0]) * crate::units::DEG, number(&pair[1]) * 1e-6])
            .collect();
        back.disc.modification.free_form = Some(Relief::through(&free));
    }
    let outline = |m: &Machine| Outline::new(m.profile(), m.designed_relief(), 0.0).unwrap();
    let (a, b) = (outline(&machine), outline(&back));
    let table = b.table();
    for i in 0..200 {
        let place = a.at(0.16 * f64::from(i) / 200.0).place;
        assert!(b.distance(place, &table).0.abs() < 1.2e-6, "{i} {:e}", b.distance(place, &table).0);
    }
}

#[test]
fn invalid_points_are_refused_with_line_and_remedy() {
    let machine = tao2024();
    let list = |rows: &str| format!("XYZIJK METRIC\n{rows}");
    for (text, line) in [
        (String::new(), None),
        ("x_mm,y_mm\n".to_owned(), Some(1)),
        ("x_mm,y_mm\n1,0,078\n".to_owned(), Some(2)),
        ("x_mm,y_mm,nx\n1,2,1\n".to_owned(), Some(1)),
        ("XYZIJK\n1 2 3 1 0 0\n".to_owned(), Some(1)),
        (list("1 2 3 1 0\n"), Some(2)),
        (list("1,5 2 3 1 0 0\n"), Some(2)),
        (list("1 2 3 0 0 1\n"), Some(2)),
        (list("1 2 3 0 0 0\n"), Some(2)),
        (list("1 2 nan 1 0 0\n"), Some(2)),
        (list("1e9 2 3 1 0 0\n"), Some(2)),
        ("A = HEADER / 1e99\n".to_owned(), Some(1)),
        ("A = PSET / 2, 1,2,3\nB = END\n".to_owned(), Some(1)),
        ("A = PSET / 1e300, 1,2,3\nB = END\n".to_owned(), Some(1)),
        ("A = POINT / 1,2\nB = END\n".to_owned(), Some(1)),
        ("A = MDI / 1, 1,2,3,1,0,0\n".to_owned(), Some(1)),
        ("A = END\n".to_owned(), Some(1)),
    ] {
        let error = read_points(text.as_bytes(), "points").unwrap_err();
        let found = match &error {
            ExchangeError::Points { line, .. } => Some(*line),
            ExchangeError::Table(error) => error.line,
            _ => None,
        };
        assert_eq!(found, line, "{text:?}: {error}");
        assert!(!error.remedy().is_empty());
    }
    // Readable points that do not belong to this disc.
    let circle = |count: usize, radius: f64| -> String {
        let at = |i: usize| radius * unit(std::f64::consts::TAU * i as f64 / count as f64);
        "x_mm,y_mm\n".to_owned()
            + &(0..count).map(|i| format!("{},{}\n", at(i).x, at(i).y)).collect::<String>()
    };
    let line: String = "x_mm,y_mm\n".to_owned() + &(0..100).map(|i| format!("{i},{i}\n")).collect::<String>();
    let same = "x_mm,y_mm\n".to_owned() + &"1,1\n".repeat(100);
    for text in [circle(20, 61.0), circle(500, 30.0), circle(500, 61.0), line, same] {
        let error = import_flank(&machine, text.as_bytes(), "points", &options(measured())).unwrap_err();
        assert!(matches!(error, ExchangeError::Fit { .. }) && !error.remedy().is_empty(), "{error}");
    }
    let disc = options(FlankTarget::Harmonics { disc: 7 });
    assert!(matches!(
        import_flank(&machine, b"", "p", &disc),
        Err(ExchangeError::NoDisc { disc: 8, count: 2 })
    ));
}

/// Missing metal of an artificial flank over τ: the part common to all lobes (smooth waves, a narrow peak at
/// the roots as in some generators), run-out and pitch.
struct Made {
    mean: f64,
    waves: Vec<(f64, f64, f64)>,
    bump: f64,
    around: FlankError,
}

impl Made {
    fn random(random: &mut Pcg64) -> Made {
        let harmonic =
            |order, amplitude, phase, direction| FlankHarmonic { order, amplitude, phase, direction };
        let size = random.random_range(0.0..8e-6);
        Made {
            mean: random.random_range(-5e-6..25e-6),
            waves: (1..5)
                .map(|k| (f64::from(k), size / f64::from(k), random.random_range(-3.0..3.0)))
                .collect(),
            bump: random.random_range(0.0..8e-6),
            around: FlankError {
                harmonics: vec![
                    harmonic(
                        2,
                        random.random_range(0.0..5e-6),
                        random.random_range(-1.0..1.0),
                        FlankDirection::Inwards,
                    ),
                    harmonic(
                        3,
                        random.random_range(0.0..5e-6),
                        random.random_range(-1.0..1.0),
                        FlankDirection::Around,
                    ),
                ],
                measured: None,
            },
        }
    }

    fn common(&self, phi: f64) -> f64 {
        let waves: f64 = self.waves.iter().map(|(k, size, phase)| size * (k * phi + phase).cos()).sum();
        self.mean + waves + self.bump * (-(phi / 0.25).powi(2)).exp()
    }

    fn depth(&self, machine: &Machine, tau: f64) -> f64 {
        let profile = machine.profile();
        self.common(profile.meshing_angle(tau)) + self.around.depth(tau, profile.outward_normal(tau))
    }

    /// In the form of a measuring machine's output: each lobe with its own positions and densities, displaced,
    /// rotated.
    fn points(&self, machine: &Machine, per_lobe: usize, noise: f64, random: &mut Pcg64) -> String {
        let profile = machine.profile();
        let normal = Normal::new(0.0, noise).unwrap();
        let count = per_lobe * profile.lobe_count();
        // Within half a lobe; beyond it the smallest rotation belongs to another lobe.
        let rotation = random.random_range(-0.07..0.07);
        let mut text = String::from("x_mm,y_mm\n");
        for i in 0..count {
            let even = (i as f64 + 0.4 * random.random::<f64>()) / count as f64;
            let tau = std::f64::consts::TAU * even
                + 0.3 / count as f64 * (profile.lobe_count() as f64 * even).sin();
            let depth = self.depth(machine, tau) + normal.sample(random);
            let place = profile.flank_point(tau) - depth * profile.outward_normal(tau);
            let place = turned(place, unit(rotation)) + Vec2::new(1e-5, -2e-5);
            text += &format!("{:.6},{:.6}\n", place.x * 1e3, place.y * 1e3);
        }
        text
    }
}

/// Flank found by `import flank` as text of a design, in one of the three forms: the depth over τ that the
/// program computes from it.
fn read_back(import: &FlankImport) -> Box<dyn Fn(f64) -> f64> {
    let template = crate::templates::TAO2024.text;
    let (before, rest) = template.split_once("[disc.modification]").unwrap();
    let after = &rest[rest.find("\n[").unwrap()..];
    let nominal = tao2024();
    let profile = nominal.profile();
    let parse = |text: &str| {
        let design =
            crate::design::Design::parse(text, "d.toml").unwrap_or_else(|e| panic!("{e}: {}", import.toml));
        let again = crate::design::Design::parse(&design.to_toml(), "e.toml").unwrap();
        assert_eq!(again.machine(), design.machine());
        design
    };
    if import.toml.contains("[disc.modification]") {
        let machine = parse(&format!("{before}{}{after}", import.toml)).machine();
        let cut = Outline::new(machine.profile(), machine.designed_relief(), 0.0).unwrap();
        let nominal = Outline::new(profile, Relief::uniform(0.0), 0.0).unwrap();
        let table = nominal.table();
        return Box::new(move |tau| -nominal.distance(cut.at(tau).place, &table).0);
    }
    let error = match &import.csv {
        Some(csv) => {
            let file = crate::design::InputFile("measured-flank.csv".to_owned());
            parse(&format!("{template}\n{}", import.toml));
            crate::analyses::inputs::measured_flank(&file, csv.as_bytes(), profile.lobe_count()).unwrap()
        }
        None => parse(&format!("{template}\n{}", import.toml)).given_errors().unwrap().discs[0].flank.clone(),
    };
    Box::new(move |tau| error.depth(tau, profile.outward_normal(tau)))
}

/// Root mean square difference of two flanks in m, except for a displacement and a rotation of the whole disc,
/// which no form contains; and the difference of their mean depths.
fn difference(machine: &Machine, a: &dyn Fn(f64) -> f64, b: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let profile = machine.profile();
    let count = 4000;
    let rows: Vec<(nalgebra::Vector3<f64>, f64)> = (0..count)
        .map(|i| {
            let tau = std::f64::consts::TAU * f64::from(i) / f64::from(count);
            let normal = profile.outward_normal(tau);
            let lever = profile.lever_arm(profile.meshing_angle(tau)) / profile.largest_lever_arm();
            (nalgebra::Vector3::new(normal.x, normal.y, lever), a(tau) - b(tau))
        })
        .collect();
    let mut matrix = nalgebra::Matrix3::<f64>::zeros();
    let mut load = nalgebra::Vector3::<f64>::zeros();
    for (row, off) in &rows {
        matrix += row * row.transpose();
        load += *off * row;
    }
    let moved = matrix.cholesky().unwrap().solve(&load);
    let rests: Vec<f64> = rows.iter().map(|(row, off)| off - row.dot(&moved)).collect();
    let square = rests.iter().map(|rest| rest * rest).sum::<f64>() / f64::from(count);
    (square.sqrt(), rests.iter().sum::<f64>() / f64::from(count))
}

/// Random flanks in the form of measuring machines, written in each of the three forms, read by the design: the
/// same flank within 0.35 µm and a part of the noise, its mean depth within 0.1 µm and a twentieth of the
/// noise. For a modification the part common to all lobes.
#[test]
fn every_form_reproduces_the_flank_and_its_mean_depth() {
    let machine = tao2024();
    let mut random = Pcg64::seed_from_u64(5);
    for case in 0..6 {
        let made = Made::random(&mut random);
        let (per_lobe, noise) = (random.random_range(20..50), [0.0, 0.3e-6, 1e-6][case % 3]);
        let text = made.points(&machine, per_lobe, noise, &mut random);
        let whole = |tau: f64| made.depth(&machine, tau);
        let common = |tau: f64| made.common(machine.profile().meshing_angle(tau));
        for (target, share) in [
            (FlankTarget::Modification, 0.3),
            (FlankTarget::Harmonics { disc: 0 }, 0.3),
            // Every point is kept with its noise.
            (FlankTarget::MeasuredFlank { disc: 0, file: "measured-flank.csv".into() }, 1.2),
        ] {
            let import = import_flank(&machine, text.as_bytes(), "points", &options(target.clone())).unwrap();
            let back = read_back(&import);
            let (off, mean) = match target {
                FlankTarget::Modification => difference(&machine, &back, &common),
                _ => difference(&machine, &back, &whole),
            };
            assert!(
                off < 0.35e-6 + share * noise,
                "{case} {target:?} {per_lobe} {noise:e}: {off:e}\n{}",
                import.toml
            );
            assert!(mean.abs() < 0.1e-6 + 0.05 * noise, "{case} {target:?}: {mean:e}\n{}", import.toml);
        }
    }
}

/// Teeth of a public generator: 10 µm are missing everywhere and 30 µm at roots and tips, within some degrees
/// of the root. Every form reproduces this, and the design accepts the output.
#[test]
fn a_form_that_is_steep_at_the_roots() {
    let machine = tao2024();
    let made =
        Made { mean: 15e-6, waves: vec![(2.0, 5e-6, 0.0)], bump: 10e-6, around: FlankError::default() };
    let mut random = Pcg64::seed_from_u64(6);
    let text = made.points(&machine, 100, 0.0, &mut random);
    let import =
        import_flank(&machine, text.as_bytes(), "points", &options(FlankTarget::Modification)).unwrap();
    let free = import.toml.lines().find(|line| line.starts_with("free_form_deg_um")).unwrap();
    assert!(!free.contains(", -"), "{free}");
    let (low, high) = import.split.common_range();
    assert!((low - 10e-6).abs() < 0.2e-6 && (high - 30e-6).abs() < 0.3e-6, "{low:e} {high:e}");
    assert!(
        (import.split.modification[0] - 15e-6 - 10e-6 * 0.25 * 0.5 / std::f64::consts::PI.sqrt()).abs()
            < 0.1e-6
    );
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(1000))]
    #[test]
    fn any_bytes_give_a_result_or_an_error(
        bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..120),
        text in "(XYZIJK METRIC\n|A = (PSET|MDI|POINT|HEADER|END|CURVE) /? ?|[0-9]{1,2}|[., \t]|-|e9|\n|=|\\$\\$|x_mm,y_mm\n){0,40}",
    ) {
        let _ = read_points(&bytes, "p");
        if let Ok(set) = read_points(text.as_bytes(), "p") {
            assert!(set.points.len() == set.lines.len() && set.points.iter().all(|p| p.norm().is_finite()));
        }
    }
}
