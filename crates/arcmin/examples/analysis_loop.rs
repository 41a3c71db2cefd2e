//! A loop of one analysis, to hold a loop from another language against: milliseconds a call, the best of three.
//!
//! `cargo run --release -p arcmin --example analysis_loop -- contact 1000`

use std::time::Instant;

use arcmin::analyses::{NoHost, by_name};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_else(|| "contact".into());
    let calls: usize = words.next().map_or(Ok(1000), |word| word.parse())?;
    let design = arcmin::templates::design("rv-40e-81").ok_or("no such design")?;
    let analysis = by_name(&name).ok_or("no such analysis")?;
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let started = Instant::now();
        for _ in 0..calls {
            analysis.run(&design, "", "example", &NoHost)?;
        }
        best = best.min(started.elapsed().as_secs_f64() * 1e3 / calls as f64);
    }
    println!("{best}");
    Ok(())
}
