use std::process::ExitCode;

use peristitch::gmsh;

fn main() -> ExitCode {
    if std::env::args_os()
        .nth(1)
        .is_some_and(|command| command == gmsh::WORKER_COMMAND)
    {
        return gmsh::worker_main();
    }
    ExitCode::SUCCESS
}
