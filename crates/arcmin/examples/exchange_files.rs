//! Writes every export of the shipped designs, and the exact flank beside them, for the checks in
//! `validation/exchange`: `cargo run --release --example exchange_files -- DIR`.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use arcmin::design::Design;
use arcmin::exchange::{Flank, Parts, ProfileExport, ProfileOptions, Stamp};
use arcmin::geometry::Relief;

fn main() -> Result<(), Box<dyn Error>> {
    let directory = std::env::args().nth(1).ok_or("usage: exchange_files DIR")?;
    for template in arcmin::templates::TEMPLATES {
        let design = Design::parse(template.text, template.name).map_err(|error| error.to_string())?;
        let machine = design.machine();
        let wear = Relief::from_samples(Relief::grid(180).map(|phi| 1e-5 * (1.2 + phi.sin())).collect());
        for (name, options) in [
            ("modified", ProfileOptions::default()),
            ("worn", ProfileOptions { flank: Flank::Worn(wear), ..ProfileOptions::default() }),
            ("wire", ProfileOptions { offset: 1.5e-4, tolerance: 5e-7, ..ProfileOptions::default() }),
        ] {
            let export = ProfileExport::new(&machine, Stamp::of(&design), options)?;
            let place = Path::new(&directory).join(format!("{}-{name}", template.name));
            fs::create_dir_all(&place)?;
            fs::write(place.join("profile.dxf"), export.dxf())?;
            fs::write(place.join("profile.csv"), export.csv())?;
            fs::write(place.join("profile.svg"), export.svg())?;
            fs::write(place.join("discs.step"), export.step(Parts::Discs))?;
            fs::write(place.join("pin.step"), export.step(Parts::Pin))?;
            fs::write(place.join("crankshaft.step"), export.step(Parts::Crankshaft))?;
            let assembly = Parts::Assembly { crank_angle: 0.4 };
            fs::write(place.join("assembly.step"), export.step(assembly))?;
            fs::write(place.join("exact.csv"), exact(&export))?;
            fs::write(place.join("figures.json"), figures(&export))?;
        }
    }
    Ok(())
}

/// The exact edge, far denser than any tolerance.
fn exact(export: &ProfileExport) -> String {
    let outline = export.outline();
    let count = 4000 * outline.lobe_count();
    let mut text = String::from("x_mm,y_mm\n");
    for i in 0..count {
        let place = outline.at(std::f64::consts::TAU * i as f64 / count as f64).place * 1e3;
        let _ = writeln!(text, "{},{}", place.x, place.y);
    }
    text
}

fn figures(export: &ProfileExport) -> String {
    let parts: Vec<String> = export
        .solid_figures()
        .iter()
        .map(|part| {
            format!(
                "{{\"name\": \"{}\", \"volume_mm3\": {}, \"surface_mm2\": {}}}",
                part.name,
                part.volume * 1e9,
                part.surface * 1e6
            )
        })
        .collect();
    format!(
        "{{\"polyline_deviation_mm\": {}, \"spline_deviation_mm\": {}, \"parts\": [{}]}}\n",
        export.polyline_deviation() * 1e3,
        export.spline_deviation() * 1e3,
        parts.join(", ")
    )
}
