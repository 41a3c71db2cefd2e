//! Writes every export of the shipped designs, and the figures that a reader must find, for the checks in
//! `validation/exchange`: `cargo run --release --example exchange_files -- DIR`.

use std::error::Error;
use std::fs;
use std::path::Path;

use arcmin::design::Design;
use arcmin::exchange::{Contour, Flank, Parts, ProfileExport, ProfileOptions, Stamp};
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
            let (offset, tolerance) = (options.offset, options.tolerance);
            let second = ProfileOptions { disc: Some(1), ..options.clone() };
            let second = ProfileExport::new(&machine, Stamp::of(&design), second)?;
            let export = ProfileExport::new(&machine, Stamp::of(&design), options)?;
            let place = Path::new(&directory).join(format!("{}-{name}", template.name));
            fs::create_dir_all(&place)?;
            fs::write(place.join("profile.dxf"), export.dxf(Contour::Both))?;
            fs::write(place.join("profile.csv"), export.csv())?;
            fs::write(place.join("profile.svg"), export.svg())?;
            fs::write(place.join("discs.step"), export.step(Parts::Discs)?)?;
            fs::write(place.join("pin.step"), export.step(Parts::Pin)?)?;
            fs::write(place.join("crankshaft.step"), export.step(Parts::Crankshaft)?)?;
            let assembly = Parts::Assembly { crank_angle: 0.4 };
            fs::write(place.join("assembly.step"), export.step(assembly)?)?;
            fs::write(place.join("cutter-polyline.dxf"), second.dxf(Contour::Polyline))?;
            fs::write(place.join("cutter-spline.dxf"), second.dxf(Contour::Spline))?;
            for (stem, export, parts) in [
                ("discs", &export, Parts::Discs),
                ("disc-2", &second, Parts::Discs),
                ("pin", &export, Parts::Pin),
                ("crankshaft", &export, Parts::Crankshaft),
                ("assembly", &export, assembly),
            ] {
                fs::write(place.join(format!("{stem}.stl")), export.stl(parts)?)?;
                let folder = place.join(format!("{stem}.3mf.d"));
                for (name, bytes) in export.three_mf(parts)? {
                    let file = folder.join(name);
                    fs::create_dir_all(file.parent().unwrap_or(&folder))?;
                    fs::write(file, bytes)?;
                }
            }
            let crankshafts = machine.crankshafts().count;
            fs::write(place.join("figures.json"), figures(&export, worn, [offset, tolerance], crankshafts))?;
        }
    }
    Ok(())
}

fn figures(export: &ProfileExport, worn: bool, [offset, tolerance]: [f64; 2], crankshafts: usize) -> String {
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
         \"wear_mm\": {}, \"offset_mm\": {}, \"tolerance_mm\": {}, \"crankshaft_count\": {crankshafts}, \"polyline_deviation_mm\": {}, \"spline_deviation_mm\": {}, \
         \"parts\": [{}]}}\n",
        profile.pin_count,
        profile.pin_circle_radius * 1e3,
        profile.eccentricity * 1e3,
        profile.pin_radius * 1e3,
        if worn { 0.01 } else { 0.0 },
        offset * 1e3,
        tolerance * 1e3,
        export.polyline_deviation() * 1e3,
        export.spline_deviation() * 1e3,
        parts.join(", ")
    )
}
