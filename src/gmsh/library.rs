//! Finding the shared library of Gmsh, which is loaded when a mesh is wanted, not linked.
//!
//! Order: `$GMSH_LIB` (and then nothing else); the nearest `.venv`, upwards from the current
//! directory and from the executable; the system's directories. Within a directory the newest
//! version comes first.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The Debian packages without which Gmsh's wheel does not load on a bare system.
pub const DEBIAN_PACKAGES: &str = "libglu1-mesa libgl1 libxrender1 libxcursor1 libxfixes3 libxext6 \
     libxft2 libfontconfig1 libxinerama1 libx11-6 libgomp1";

/// The variable that names the library to use.
pub const VARIABLE: &str = "GMSH_LIB";

/// The places in which the library is sought.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// The value of `$GMSH_LIB`.
    pub explicit: Option<PathBuf>,
    /// Directories whose ancestors may hold a `.venv`.
    pub starts: Vec<PathBuf>,
    /// Directories of shared libraries.
    pub system: Vec<PathBuf>,
}

/// The libraries that were found, and the places that were searched.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Search {
    /// Candidates, best first.
    pub found: Vec<PathBuf>,
    /// Patterns that were looked at, for the error message.
    pub tried: Vec<String>,
}

impl Places {
    /// The environment, the current directory and the executable of this process.
    pub fn of_this_process() -> Places {
        let executable = std::env::current_exe().ok();
        let executable_directory = executable.as_deref().and_then(Path::parent);
        let starts = std::env::current_dir().ok().into_iter();
        Places {
            explicit: std::env::var_os(VARIABLE)
                .filter(|value| !value.is_empty())
                .map(PathBuf::from),
            starts: starts
                .chain(executable_directory.map(Path::to_owned))
                .collect(),
            system: system_directories(),
        }
    }

    pub fn search(&self) -> Search {
        if let Some(file) = &self.explicit {
            return Search {
                found: file.is_file().then(|| file.clone()).into_iter().collect(),
                tried: vec![format!("${VARIABLE} = {}", file.display())],
            };
        }
        let mut search = Search::default();
        for environment in self.virtual_environments() {
            search.look_into(&environment.join("lib"));
            for packages in site_packages(&environment) {
                search.look_below(&packages);
            }
        }
        if search.tried.is_empty() {
            let upwards = self.starts.iter().map(|start| start.display().to_string());
            let upwards: Vec<String> = upwards.collect();
            search.tried.push(format!(
                ".venv, upwards from {}",
                upwards.join(" and from ")
            ));
        }
        for directory in &self.system {
            search.look_into(directory);
        }
        search.without_aliases()
    }

    /// Every start's nearest `.venv`.
    pub fn virtual_environments(&self) -> Vec<PathBuf> {
        let mut environments: Vec<PathBuf> = Vec::new();
        for start in &self.starts {
            let mut upwards = start.ancestors().map(|directory| directory.join(".venv"));
            if let Some(found) = upwards.find(|path| path.is_dir())
                && !environments.contains(&found)
            {
                environments.push(found);
            }
        }
        environments
    }
}

impl Search {
    fn look_into(&mut self, directory: &Path) {
        self.tried
            .push(directory.join("libgmsh.so*").display().to_string());
        self.add_libraries(directory);
    }

    /// Looks into a Python package directory, and below it into what is Gmsh's.
    fn look_below(&mut self, directory: &Path) {
        self.tried
            .push(directory.join("**/libgmsh.so*").display().to_string());
        self.add_libraries(directory);
        let gmsh =
            |path: &PathBuf| path.is_dir() && file_name(path).to_ascii_lowercase().contains("gmsh");
        let mut pending: Vec<PathBuf> = entries(directory).into_iter().filter(gmsh).collect();
        while let Some(directory) = pending.pop() {
            self.add_libraries(&directory);
            let real = |path: &PathBuf| path.is_dir() && !path.is_symlink();
            pending.extend(entries(&directory).into_iter().filter(real));
        }
    }

    fn add_libraries(&mut self, directory: &Path) {
        let mut libraries: Vec<(Vec<u32>, PathBuf)> = entries(directory)
            .into_iter()
            .filter_map(|path| Some((version(&path)?, path)))
            .filter(|(_, path)| path.is_file())
            .collect();
        libraries.sort_by(|a, b| b.cmp(a));
        self.found
            .extend(libraries.into_iter().map(|(_, path)| path));
    }

    /// Keeps the first name of each file: `libgmsh.so.4.8` is often a link to `libgmsh.so.4.8.4`.
    fn without_aliases(mut self) -> Search {
        let mut seen = BTreeSet::new();
        self.found
            .retain(|path| seen.insert(path.canonicalize().unwrap_or_else(|_| path.clone())));
        self
    }
}

/// The version in a library's file name: `libgmsh.so.4.15` → `[4, 15]`, `libgmsh.so` → `[]`.
/// None if the file is not a Gmsh library by its name.
pub fn version(path: &Path) -> Option<Vec<u32>> {
    let suffix = path.file_name()?.to_str()?.strip_prefix("libgmsh.so")?;
    if suffix.is_empty() {
        return Some(Vec::new());
    }
    let numbers = suffix.strip_prefix('.')?.split('.');
    numbers.map(|number| number.parse().ok()).collect()
}

/// The file that the loader misses, from its message
/// "libGLU.so.1: cannot open shared object file: No such file or directory".
pub fn missing_dependency<'a>(library: &Path, reason: &'a str) -> Option<&'a str> {
    let (before, _) = reason.split_once(": cannot open shared object file")?;
    let missing = before.rsplit(' ').next()?;
    (Path::new(missing) != library).then_some(missing)
}

fn site_packages(environment: &Path) -> Vec<PathBuf> {
    entries(&environment.join("lib"))
        .into_iter()
        .filter(|path| file_name(path).starts_with("python"))
        .map(|path| path.join("site-packages"))
        .filter(|path| path.is_dir())
        .collect()
}

fn system_directories() -> Vec<PathBuf> {
    let multiarch = format!("/usr/lib/{}-linux-gnu", std::env::consts::ARCH);
    let usual = [
        "/usr/local/lib",
        "/usr/local/lib64",
        &multiarch,
        "/usr/lib64",
        "/usr/lib",
    ];
    let user = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let user = std::env::split_paths(&user).filter(|path| path.is_absolute());
    user.chain(usual.iter().map(PathBuf::from)).collect()
}

/// The entries of a directory, sorted; none if it cannot be read.
fn entries(directory: &Path) -> Vec<PathBuf> {
    let Ok(listing) = std::fs::read_dir(directory) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = listing.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

fn file_name(path: &Path) -> &str {
    path.file_name().and_then(OsStr::to_str).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn touch(path: &Path) {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "").unwrap();
    }

    #[test]
    fn version_is_read_from_the_file_name() {
        assert_eq!(
            version(Path::new("/a/libgmsh.so.4.15.2")),
            Some(vec![4, 15, 2])
        );
        assert_eq!(version(Path::new("libgmsh.so")), Some(vec![]));
        assert_eq!(version(Path::new("libgmsh.so.old")), None);
        assert_eq!(version(Path::new("libgmshfoo.so")), None);
    }

    #[test]
    fn newest_version_first_and_venv_before_system() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let system = root.join("system");
        touch(&system.join("libgmsh.so.4.8.4"));
        touch(&system.join("libgmsh.so.4.11"));
        touch(&root.join("project/.venv/lib/libgmsh.so.4.9"));
        let wheel = "project/.venv/lib/python3.11/site-packages/gmsh-4.13/lib/libgmsh.so.4.13";
        touch(&root.join(wheel));
        touch(&root.join("project/.venv/lib/python3.11/site-packages/numpy/libgmsh.so.4.1"));
        let places = Places {
            explicit: None,
            starts: vec![root.join("project/deep/inside"), root.join("project")],
            system: vec![system.clone()],
        };
        assert_eq!(
            places.search().found,
            [
                root.join("project/.venv/lib/libgmsh.so.4.9"),
                root.join(wheel),
                system.join("libgmsh.so.4.11"),
                system.join("libgmsh.so.4.8.4"),
            ]
        );
    }

    #[test]
    fn links_to_one_file_are_one_candidate() {
        let folder = tempfile::tempdir().unwrap();
        touch(&folder.path().join("libgmsh.so.4.8.4"));
        std::os::unix::fs::symlink("libgmsh.so.4.8.4", folder.path().join("libgmsh.so")).unwrap();
        std::os::unix::fs::symlink("nowhere", folder.path().join("libgmsh.so.4.9")).unwrap();
        let places = Places {
            system: vec![folder.path().to_owned()],
            ..Places::default()
        };
        assert_eq!(
            places.search().found,
            [folder.path().join("libgmsh.so.4.8.4")]
        );
    }

    #[test]
    fn explicit_library_excludes_all_others() {
        let folder = tempfile::tempdir().unwrap();
        touch(&folder.path().join("libgmsh.so.4.8"));
        let places = Places {
            explicit: Some(folder.path().join("mine.so")),
            system: vec![folder.path().to_owned()],
            ..Places::default()
        };
        let search = places.search();
        assert!(search.found.is_empty());
        assert_eq!(search.tried.len(), 1);
        assert!(search.tried[0].contains("mine.so"));
        touch(&folder.path().join("mine.so"));
        assert_eq!(places.search().found, [folder.path().join("mine.so")]);
    }

    #[test]
    fn search_tells_where_it_looked() {
        let folder = tempfile::tempdir().unwrap();
        let places = Places {
            explicit: None,
            starts: vec![folder.path().join("project")],
            system: vec![folder.path().join("lib")],
        };
        let search = places.search();
        assert!(search.found.is_empty());
        assert!(search.tried[0].starts_with(".venv, upwards from"));
        assert!(search.tried[1].ends_with("lib/libgmsh.so*"));
    }

    #[test]
    fn missing_system_library_is_named() {
        let library = Path::new("/v/libgmsh.so.4.15");
        let reason = "libGLU.so.1: cannot open shared object file: No such file or directory";
        assert_eq!(missing_dependency(library, reason), Some("libGLU.so.1"));
        let itself = "/v/libgmsh.so.4.15: cannot open shared object file: No such file";
        assert_eq!(missing_dependency(library, itself), None);
        assert_eq!(
            missing_dependency(library, "/v/x: invalid ELF header"),
            None
        );
    }
}
