use std::path::PathBuf;

use arcmin::templates::TEMPLATES;

use crate::failure::Failure;
use crate::run::{Verdict, say, write_file};

#[derive(Debug, clap::Args)]
#[command(
    allow_missing_positional = true,
    long_about = "Writes a design file that can be run as it is. Its comments say which values its source gives and which are assumed, and why.\n\n\
                  Templates:\n  rv-40e-81  RV-40E-81 of Tao2024: 40 pins, 39 lobes, ratio 81, 412 N·m (default)\n  rv-80e     RV-80E with the teeth of Yang 2021: ratio 153, 784 N·m",
    after_help = "Examples:\n  arcmin new my-reducer.toml\n  arcmin new rv-80e bigger.toml --force"
)]
pub struct Options {
    /// Template to start from.
    #[arg(default_value = TEMPLATES[0].name)]
    template: String,
    /// File to write.
    file: PathBuf,
    /// Overwrite the file if it exists.
    #[arg(long)]
    force: bool,
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let Some(template) = TEMPLATES.iter().find(|template| template.name == options.template) else {
        return Err(Failure::UnknownTemplate { name: options.template });
    };
    if options.file.exists() && !options.force {
        return Err(Failure::Exists { path: options.file });
    }
    write_file(&options.file, template.text.as_bytes())?;
    let file = options.file.display();
    say(&format!("{file}: {}\nnext: arcmin check {file}", template.summary));
    Ok(Verdict::Fine)
}
