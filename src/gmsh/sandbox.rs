//! Limits of the worker while Gmsh runs a script: it may read files, and write into its own folder.
//!
//! The kernel keeps to it (Landlock, Linux 5.13 and newer): no program is started, no file written or removed
//! elsewhere, from Linux 6.7 on no connection made. An older kernel does what it can; what the script's text
//! shows has been refused before, by [`super::guard`].

use crate::phases::{machine_memory, reserved_memory};
use landlock::{
    ABI, Access, AccessFs, AccessNet, PathBeneath, PathFd, Ruleset, RulesetAttr,
    RulesetCreatedAttr, RulesetError, RulesetStatus,
};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::path::Path;

/// The newest set of rights that is asked for; a kernel that knows fewer takes those.
const RIGHTS: ABI = ABI::V4;

/// Shuts the process, and all that it starts, into its own `folder`. Returns whether the kernel does so.
///
/// # Errors
/// The folder cannot be opened, or the kernel refuses.
pub(super) fn shut_in(folder: &Path) -> Result<bool, RulesetError> {
    let writing = AccessFs::from_write(RIGHTS) | AccessFs::Execute;
    let mut rules = Ruleset::default()
        .handle_access(writing)?
        .handle_access(AccessNet::from_all(RIGHTS))?
        .create()?;
    // Gmsh and its libraries throw things away.
    for path in [folder, Path::new("/dev/null")] {
        if let Ok(open) = PathFd::new(path) {
            let rights = match path.is_dir() {
                true => AccessFs::from_write(RIGHTS),
                false => AccessFs::WriteFile.into(),
            };
            rules = rules.add_rule(PathBeneath::new(open, rights))?;
        }
    }
    Ok(rules.restrict_self()?.ruleset != RulesetStatus::NotEnforced)
}

/// Share of the machine's memory that Gmsh may take, as address space; threads and libraries reserve some of it.
const MEMORY_SHARE: f64 = 0.5;
const LEAST_MEMORY: f64 = 8e9;

/// Ends an endless hunger for memory with Gmsh, not with the machine.
pub(super) fn limit_memory() {
    let machine = machine_memory().unwrap_or(0) as f64;
    let bytes = (MEMORY_SHARE * machine).max(LEAST_MEMORY) as u64;
    // Whoever has reserved more already counts memory in another way: sanitizers reserve terabytes.
    if reserved_memory().is_some_and(|reserved| reserved > bytes) {
        return;
    }
    // A lower limit from outside stays.
    let bytes = getrlimit(Resource::As)
        .current
        .map_or(bytes, |outside| outside.min(bytes));
    let limit = Rlimit {
        current: Some(bytes),
        maximum: Some(bytes),
    };
    // It can only be lowered, which is always allowed.
    let _ = setrlimit(Resource::As, limit);
}
