use std::path::Path;

use arcmin::geometry::FlankError;
use arcmin::machine::{BoreError, Machine, ManufacturingErrors, RunOut};
use arcmin::units::{ARCMIN, DEG, UM};
use serde_json::{Value, json};

use super::joints::Joints;
use crate::failure::Failure;
use crate::run::{Cell, Columns, Run, Table};

/// Options of everything that takes manufacturing errors; they act with bearings.
#[derive(Debug, Clone, PartialEq, clap::Args)]
pub struct Options {
    /// Manufacturing errors [default: those of the design's [errors], if it has any].
    #[arg(long, value_enum)]
    pub errors: Option<Choice>,
    /// Seed of the machine that --errors drawn draws [default: 1].
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Choice {
    /// Those of the design's [errors].
    Given,
    /// Drawn from the design's [tolerances] with --seed.
    Drawn,
    /// The nominal machine.
    None,
}

/// Manufacturing errors of a run and where they come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviations {
    pub errors: ManufacturingErrors,
    pub choice: Choice,
    pub seed: Option<u64>,
    /// Whether the design gives errors that ideal joints leave out.
    left_out: bool,
}

impl Deviations {
    /// Reads or draws what the options ask for. `design` is the path of the design file, beside which
    /// measured flanks lie.
    fn new(run: &Run, design: &Path, machine: &Machine, options: &Options) -> Result<Deviations, Failure> {
        let given = run.design.given_errors();
        let choice = options.errors.unwrap_or(if given.is_some() { Choice::Given } else { Choice::None });
        if options.seed.is_some() && choice != Choice::Drawn {
            return Err(usage("--seed draws nothing here", "it goes with --errors drawn"));
        }
        let errors = match choice {
            Choice::None => ManufacturingErrors::default(),
            Choice::Given => {
                let mut errors = given.ok_or_else(|| {
                    usage(
                        "the design gives no manufacturing errors",
                        "add a section [errors]; `arcmin keys` lists its keys",
                    )
                })?;
                for flank in run.design.measured_flanks() {
                    let measured =
                        read_flank(&design.with_file_name(&flank.file), machine.ring.pin_count - 1)?;
                    if errors.discs.len() <= flank.disc {
                        errors.discs.resize_with(flank.disc + 1, Default::default);
                    }
                    errors.discs[flank.disc].flank.measured = measured.measured;
                }
                errors
            }
            Choice::Drawn => {
                let tolerances = run.design.drawing_tolerances().ok_or_else(|| {
                    usage(
                        "the design gives no tolerances to draw from",
                        "add a section [tolerances]; `arcmin keys` lists its keys",
                    )
                })?;
                ManufacturingErrors::draw(machine, &tolerances, options.seed.unwrap_or(1))
            }
        };
        let seed = (choice == Choice::Drawn).then(|| options.seed.unwrap_or(1));
        Ok(Deviations { errors, choice, seed, left_out: false })
    }

    /// As [`Deviations::new`], said on the terminal, errors.csv staged. Ideal joints have no place for
    /// errors: asking for them is wrong usage, and a design that gives some is told so.
    pub fn with_joints(
        run: &mut Run,
        design: &Path,
        machine: &Machine,
        options: &Options,
        joints: Joints,
    ) -> Result<Deviations, Failure> {
        let mut wanted = options.clone();
        let mut left_out = false;
        if joints == Joints::Ideal {
            match wanted.errors {
                Some(Choice::Given | Choice::Drawn) => {
                    return Err(usage(
                        "ideal joints have no place for manufacturing errors",
                        "add --joints bearings",
                    ));
                }
                None if run.design.given_errors().is_some() => {
                    run.say("the design's [errors] enter with --joints bearings only");
                    left_out = true;
                }
                _ => {}
            }
            wanted.errors = Some(Choice::None);
        }
        let deviations = Deviations { left_out, ..Deviations::new(run, design, machine, &wanted)? };
        deviations.sentence().iter().for_each(|line| run.say(line));
        if deviations.choice != Choice::None {
            run.table("errors.csv", deviations.table())?;
        }
        Ok(deviations)
    }

    /// Machines drawn with this one's seed and those that follow it.
    pub fn series(
        &self,
        run: &Run,
        machine: &Machine,
        count: u32,
    ) -> Result<Vec<(u64, ManufacturingErrors)>, Failure> {
        let (Some(seed), Some(tolerances)) = (self.seed, run.design.drawing_tolerances()) else {
            return Err(usage(
                "--machines draws the machines of a series",
                "it goes with --joints bearings --errors drawn",
            ));
        };
        let seeds = (0..u64::from(count)).map(|index| seed.wrapping_add(index));
        Ok(seeds.map(|seed| (seed, ManufacturingErrors::draw(machine, &tolerances, seed))).collect())
    }

    pub fn summary(&self) -> Value {
        let source = match self.choice {
            Choice::Given => "given",
            Choice::Drawn => "drawn",
            Choice::None => "none",
        };
        let mut summary = json!({ "source": source, "seed": self.seed });
        if self.left_out {
            summary["left_out"] = json!("the design's [errors] enter with --joints bearings only");
        }
        summary
    }

    pub fn seeds(&self) -> Vec<u64> {
        self.seed.into_iter().collect()
    }

    /// One line for terminal and report; `None` for the nominal machine.
    pub fn sentence(&self) -> Option<String> {
        match (self.choice, self.seed) {
            (Choice::None, _) => None,
            (_, Some(seed)) => Some(format!(
                "Manufacturing errors drawn from the tolerances with seed {seed}, listed in errors.csv."
            )),
            _ => Some("Manufacturing errors as given in the design, listed in errors.csv.".to_owned()),
        }
    }

    /// Every deviation that is not zero, counted as in the design file.
    pub fn table(&self) -> Table {
        let mut table = Table::new(&["part", "quantity", "value", "unit"]);
        let mut add = |part: &str, quantity: &str, value: f64, unit: &str| {
            if value != 0.0 {
                table.row(&[part.into(), quantity.into(), Cell::Number(value), unit.into()]);
            }
        };
        let e = &self.errors;
        add("pin circle", "radius", e.pin_circle_radius / UM, "um");
        add("all pins", "radius", e.pin_radius / UM, "um");
        for (i, pin) in e.pins.iter().enumerate() {
            let part = format!("pin {}", i + 1);
            for (quantity, value) in
                [("radial", pin.radial), ("tangential", pin.tangential), ("radius", pin.radius)]
            {
                add(&part, quantity, value / UM, "um");
            }
        }
        for (j, disc) in e.discs.iter().enumerate() {
            for h in &disc.flank.harmonics {
                let part = format!("disc {} flank, {} order {}", j + 1, direction(h.direction), h.order);
                add(&part, "amplitude", h.amplitude / UM, "um");
                add(&part, "phase", h.phase / DEG, "deg");
            }
            if let Some(measured) = &disc.flank.measured {
                add(&format!("disc {} flank, measured", j + 1), "deepest", measured.deepest().0 / UM, "um");
            }
        }
        for (k, eccentrics) in e.eccentrics.iter().enumerate() {
            for (j, eccentric) in eccentrics.iter().enumerate() {
                let part = format!("eccentric of disc {} on crankshaft {}", j + 1, k + 1);
                add(&part, "eccentricity", eccentric.eccentricity / UM, "um");
                add(&part, "phase", eccentric.phase / ARCMIN, "arcmin");
            }
        }
        let disc_bores = e.discs.iter().enumerate().flat_map(|(j, disc)| {
            disc.bores
                .iter()
                .enumerate()
                .map(move |(k, bore)| (format!("bore of disc {} for crankshaft {}", j + 1, k + 1), bore))
        });
        let carrier_bores = e
            .carrier_bores
            .iter()
            .enumerate()
            .map(|(k, bore)| (format!("bore of the carrier for crankshaft {}", k + 1), bore));
        for (part, BoreError { radial, tangential, diameter }) in disc_bores.chain(carrier_bores) {
            for (quantity, value) in [("radial", radial), ("tangential", tangential), ("diameter", diameter)]
            {
                add(&part, quantity, value / UM, "um");
            }
        }
        let numbered = |list: &[RunOut], what: &str| -> Vec<(String, RunOut)> {
            list.iter()
                .enumerate()
                .map(|(k, run_out)| (format!("{what} of crankshaft {}", k + 1), *run_out))
                .collect()
        };
        let single = [("pin circle", e.pin_circle_offset), ("carrier", e.carrier), ("sun", e.sun)]
            .map(|(name, r)| (name.to_owned(), r));
        for (part, RunOut { amplitude, phase }) in
            numbered(&e.journals, "journals").into_iter().chain(numbered(&e.planets, "planet")).chain(single)
        {
            if amplitude != 0.0 {
                add(&part, "run-out", amplitude / UM, "um");
                add(&part, "phase", phase / DEG, "deg");
            }
        }
        table
    }
}

fn direction(direction: arcmin::geometry::FlankDirection) -> &'static str {
    use arcmin::geometry::FlankDirection;
    match direction {
        FlankDirection::Normal => "profile",
        FlankDirection::Inwards => "radial",
        FlankDirection::Around => "pitch",
    }
}

fn usage(message: &str, help: &str) -> Failure {
    Failure::Usage { message: message.to_owned(), help: help.to_owned() }
}

/// A flank measured around the disc.
fn read_flank(path: &Path, lobe_count: usize) -> Result<FlankError, Failure> {
    use arcmin::geometry::FlankDataError;
    let columns = Columns::read(
        path,
        "a header angle_deg,depth_um, then lines such as 0.25,-1.3 around the whole disc",
    )?;
    let (angles, depths) = (columns.numbers("angle_deg")?, columns.numbers("depth_um")?);
    if let Some(row) = depths.iter().position(|depth| depth.abs() > 500.0) {
        return Err(columns.wrong(
            columns.line(row),
            &format!("a depth of {} µm is more than this program believes (500 µm)", depths[row]),
        ));
    }
    let points: Vec<(f64, f64)> =
        angles.iter().zip(&depths).map(|(angle, depth)| (angle * DEG, depth * UM)).collect();
    FlankError::from_measured(&points, lobe_count).map_err(|error| match error {
        FlankDataError::NotRising(row) => columns.wrong(
            columns.line(row),
            &format!("the angles must rise, but {}° follows {}°", angles[row], angles[row - 1]),
        ),
        FlankDataError::MoreThanATurn(row) => columns.wrong(
            columns.line(row),
            &format!("{}° lies more than a turn after the first angle, {}°", angles[row], angles[0]),
        ),
        FlankDataError::TooCoarse(row, gap, _) => columns.wrong(
            columns.line(row),
            &format!(
                "a gap of {:.3}° follows; {lobe_count} lobes need a point every {:.3}° at least",
                gap / DEG,
                90.0 / lobe_count as f64
            ),
        ),
    })
}
