//! Writes every export of the shipped designs, and the figures that a reader must find, for the checks in
//! `validation/exchange`: `cargo run --release --example exchange_files -- DIR`.

use std::error::Error;
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
        for (name, worn, options) in [
            ("modified", false, ProfileOptions::default()),
            ("worn", true, ProfileOptions { flank: Flank::Worn(wear), ..ProfileOptions::default() }),
            ("wire", false, ProfileOptions { offset: 1.5e-4, tolerance: 5e-7, ..ProfileOptions::default() }),
        ] {
            let offset = options.offset;
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
            fs::write(place.join("figures.json"), figures(&export, worn, offset))?;
        }
    }
    Ok(())
}

fn figures(export: &ProfileExport, worn: bool, offset: f64) -> String {
    let profile = export.profile();
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
        "{{\"pin_count\": {}, \"pin_circle_radius_mm\": {}, \"eccentricity_mm\": {}, \"pin_radius_mm\": {}, \
         \"wear_mm\": {}, \"offset_mm\": {}, \"polyline_deviation_mm\": {}, \"spline_deviation_mm\": {}, \
         \"parts\": [{}]}}\n",
        profile.pin_count,
        profile.pin_circle_radius * 1e3,
        profile.eccentricity * 1e3,
        profile.pin_radius * 1e3,
        if worn { 0.01 } else { 0.0 },
        offset * 1e3,
        export.polyline_deviation() * 1e3,
        export.spline_deviation() * 1e3,
        parts.join(", ")
    )
}
