use std::process::ExitCode;

fn main() -> ExitCode {
    arcmin_cli::run_command(std::env::args_os().collect()).into()
}
