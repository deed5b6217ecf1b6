use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args_os();
    if arguments
        .nth(1)
        .is_some_and(|command| command == peristitch::gmsh::WORKER_COMMAND)
    {
        return peristitch::gmsh::worker_main();
    }
    peristitch::cli::main()
}
