//! The C API of Gmsh, loaded at run time. Apart from one call of METIS in [`crate::linear_solver`], the
//! only unsafe code of the crate.
//!
//! One binary serves Gmsh 4.8 to 4.15. Of the functions used here only `gmshInitialize` differs:
//! it gained an argument in the same release that brought the symbol `gmshIsInitialized`.
//! Gmsh's state belongs to the process and is not thread-safe; a [`Session`] is therefore unique in
//! its process and stays in its thread. No pointer leaves this file, every status is checked, and
//! all that Gmsh allocates goes back to `gmshFree`.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, NulError, c_char, c_int, c_void};
use std::marker::PhantomData;
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};

use libloading::Library;
use thiserror::Error;

type Status = *mut c_int;

/// Declares the table of C functions and how it is filled from the shared library.
macro_rules! c_functions {
    ($($name:ident = $symbol:literal ($($argument:ty),*);)*) => {
        struct Functions { $($name: unsafe extern "C" fn($($argument),*),)* }

        impl Functions {
            /// # Safety
            /// The signatures below must be those of the library.
            unsafe fn load(library: &Library) -> Result<Functions, libloading::Error> {
                Ok(Functions {
                    $($name: *unsafe { library.get(concat!($symbol, "\0").as_bytes()) }?,)*
                })
            }
        }
    };
}

c_functions! {
    free = "gmshFree" (*mut c_void);
    finalize = "gmshFinalize" (Status);
    open = "gmshOpen" (*const c_char, Status);
    set_number = "gmshOptionSetNumber" (*const c_char, f64, Status);
    get_string = "gmshOptionGetString" (*const c_char, *mut *mut c_char, Status);
    generate = "gmshModelMeshGenerate" (c_int, Status);
    entities = "gmshModelGetEntities" (*mut *mut c_int, *mut usize, c_int, Status);
    groups = "gmshModelGetPhysicalGroups" (*mut *mut c_int, *mut usize, c_int, Status);
    group_name = "gmshModelGetPhysicalName" (c_int, c_int, *mut *mut c_char, Status);
    group_entities = "gmshModelGetEntitiesForPhysicalGroup"
        (c_int, c_int, *mut *mut c_int, *mut usize, Status);
    nodes = "gmshModelMeshGetNodes"
        (*mut *mut usize, *mut usize, *mut *mut f64, *mut usize, *mut *mut f64, *mut usize,
         c_int, c_int, c_int, c_int, Status);
    elements = "gmshModelMeshGetElements"
        (*mut *mut c_int, *mut usize, *mut *mut *mut usize, *mut *mut usize, *mut usize,
         *mut *mut *mut usize, *mut *mut usize, *mut usize, c_int, c_int, Status);
    element_properties = "gmshModelMeshGetElementProperties"
        (c_int, *mut *mut c_char, *mut c_int, *mut c_int, *mut c_int, *mut *mut f64, *mut usize,
         *mut c_int, Status);
    logger_start = "gmshLoggerStart" (Status);
    logger_get = "gmshLoggerGet" (*mut *mut *mut c_char, *mut usize, Status);
    last_error = "gmshLoggerGetLastError" (*mut *mut c_char, Status);
}

type InitializeFour = unsafe extern "C" fn(c_int, *mut *mut c_char, c_int, Status);
type InitializeFive = unsafe extern "C" fn(c_int, *mut *mut c_char, c_int, c_int, Status);

enum Initialize {
    /// Without the argument `run`: before the symbol `gmshIsInitialized`.
    Four(InitializeFour),
    Five(InitializeFive),
}

impl Initialize {
    /// # Safety
    /// `library` must be Gmsh.
    unsafe fn load(library: &Library) -> Result<Initialize, libloading::Error> {
        let five = unsafe { library.get::<unsafe extern "C" fn(Status)>(b"gmshIsInitialized\0") };
        let symbol = b"gmshInitialize\0";
        Ok(match five {
            Ok(_) => Initialize::Five(*unsafe { library.get(symbol) }?),
            Err(_) => Initialize::Four(*unsafe { library.get(symbol) }?),
        })
    }
}

type GetNumbers = unsafe extern "C" fn(*const c_char, *mut *mut f64, *mut usize, Status);
type GetTexts = unsafe extern "C" fn(*const c_char, *mut *mut *mut c_char, *mut usize, Status);

/// Access to the variables of a script, which Gmsh 4.8 does not give.
struct Variables {
    numbers: GetNumbers,
    texts: GetTexts,
}

impl Variables {
    /// # Safety
    /// `library` must be Gmsh.
    unsafe fn load(library: &Library) -> Option<Variables> {
        Some(Variables {
            numbers: *unsafe { library.get(b"gmshParserGetNumber\0") }.ok()?,
            texts: *unsafe { library.get(b"gmshParserGetString\0") }.ok()?,
        })
    }
}

/// Why Gmsh could not be started or a call failed.
#[derive(Debug, Error)]
pub enum FfiError {
    #[error("{library}: {reason}", library = library.display())]
    Load { library: PathBuf, reason: String },
    #[error("a Gmsh session is open in this process already")]
    SessionOpen,
    #[error("Gmsh's {function} returned {code}: {message}")]
    Call {
        function: &'static str,
        code: i32,
        message: String,
    },
    #[error("an element uses node {node}, which Gmsh does not list")]
    NodeMissing { node: usize },
    #[error("a text for Gmsh holds a NUL character")]
    Nul(#[from] NulError),
}

/// The elements of one Gmsh type within one geometrical entity.
#[derive(Debug)]
pub struct ElementBlock {
    /// Gmsh's number of the element type.
    pub kind: i32,
    pub tags: Vec<usize>,
    /// Node tags, element after element.
    pub nodes: Vec<usize>,
}

/// What Gmsh says of an element type.
#[derive(Debug)]
pub struct ElementProperties {
    /// Such as "Quadrilateral 8".
    pub name: String,
    pub order: usize,
    pub node_count: usize,
}

/// Gmsh, initialised. Dropping the guard finalises it.
pub struct Session {
    functions: Functions,
    variables: Option<Variables>,
    /// Never unloaded: Gmsh and its own libraries leave exit handlers behind.
    _library: ManuallyDrop<Library>,
    _not_send: PhantomData<*const ()>,
}

static SESSION_OPEN: AtomicBool = AtomicBool::new(false);

impl Session {
    /// Loads `library` and initialises Gmsh with `arguments` (without a program name) as its
    /// command line. The user's Gmsh configuration files are not read: the same input gives the
    /// same mesh everywhere.
    pub fn start(library: &Path, arguments: &[String]) -> Result<Session, FfiError> {
        let arguments = arguments
            .iter()
            .map(|argument| CString::new(argument.as_str()))
            .collect::<Result<Vec<CString>, _>>()?;
        let load_error = |error: libloading::Error| FfiError::Load {
            library: library.to_owned(),
            reason: error.to_string(),
        };
        // SAFETY: loading runs Gmsh's static initialisers, which have no precondition.
        let loaded = unsafe { Library::new(library) }.map_err(load_error)?;
        // SAFETY: the signatures are those of gmshc.h in 4.8.4 and in 4.15.2.
        let functions = unsafe { Functions::load(&loaded) }.map_err(load_error)?;
        let initialize = unsafe { Initialize::load(&loaded) }.map_err(load_error)?;
        let variables = unsafe { Variables::load(&loaded) };

        if SESSION_OPEN.swap(true, Ordering::SeqCst) {
            return Err(FfiError::SessionOpen);
        }
        let session = Session {
            functions,
            variables,
            _library: ManuallyDrop::new(loaded),
            _not_send: PhantomData,
        };
        session.initialize(&initialize, &arguments)?;
        Ok(session)
    }

    fn initialize(&self, function: &Initialize, arguments: &[CString]) -> Result<(), FfiError> {
        let mut argv: Vec<*mut c_char> = std::iter::once(c"gmsh")
            .chain(arguments.iter().map(CString::as_c_str))
            .map(|text| text.as_ptr().cast_mut())
            .collect();
        let argc =
            c_int::try_from(argv.len()).expect("a command line has far fewer than 2^31 words");
        argv.push(ptr::null_mut());
        let argv = argv.as_mut_ptr();
        // SAFETY: argv holds argc C strings and a null; Gmsh copies them.
        self.call("gmshInitialize", |status| match function {
            Initialize::Four(initialize) => unsafe { initialize(argc, argv, 0, status) },
            Initialize::Five(initialize) => unsafe { initialize(argc, argv, 0, 0, status) },
        })
    }

    /// Opens a file. The log tells whether it went well: the status is zero for a syntax error,
    /// and in 4.8 for a missing file too.
    pub fn open(&self, file: &str) -> Result<(), FfiError> {
        let file = CString::new(file)?;
        // SAFETY: a C string that outlives the call.
        self.call("gmshOpen", |status| unsafe {
            (self.functions.open)(file.as_ptr(), status)
        })
    }

    pub fn set_number(&self, option: &CStr, value: f64) -> Result<(), FfiError> {
        // SAFETY: a C string that outlives the call.
        self.call("gmshOptionSetNumber", |status| unsafe {
            (self.functions.set_number)(option.as_ptr(), value, status)
        })
    }

    pub fn version(&self) -> Result<String, FfiError> {
        let mut text = ptr::null_mut();
        // SAFETY: Gmsh stores an allocated C string in `text`, which take_string frees.
        self.call("gmshOptionGetString", |status| unsafe {
            (self.functions.get_string)(c"General.Version".as_ptr(), &mut text, status)
        })?;
        Ok(unsafe { self.take_string(text) })
    }

    pub fn generate(&self, dimension: i32) -> Result<(), FfiError> {
        // SAFETY: plain numbers.
        self.call("gmshModelMeshGenerate", |status| unsafe {
            (self.functions.generate)(dimension, status)
        })
    }

    /// The number of geometrical entities of a dimension.
    pub fn entity_count(&self, dimension: i32) -> Result<usize, FfiError> {
        let (mut pairs, mut length) = (ptr::null_mut(), 0);
        // SAFETY: Gmsh stores an allocated array and its length, which take_array frees.
        self.call("gmshModelGetEntities", |status| unsafe {
            (self.functions.entities)(&mut pairs, &mut length, dimension, status)
        })?;
        Ok(unsafe { self.take_array(pairs, length) }.len() / 2)
    }

    /// Dimension and tag of every physical group.
    pub fn groups(&self) -> Result<Vec<(i32, i32)>, FfiError> {
        let (mut pairs, mut length) = (ptr::null_mut(), 0);
        // SAFETY: as in entity_count.
        self.call("gmshModelGetPhysicalGroups", |status| unsafe {
            (self.functions.groups)(&mut pairs, &mut length, -1, status)
        })?;
        let pairs = unsafe { self.take_array(pairs, length) };
        Ok(pairs.chunks_exact(2).map(|p| (p[0], p[1])).collect())
    }

    /// The name of a physical group; empty if it has none.
    pub fn group_name(&self, dimension: i32, tag: i32) -> Result<String, FfiError> {
        let mut text = ptr::null_mut();
        // SAFETY: as in version.
        self.call("gmshModelGetPhysicalName", |status| unsafe {
            (self.functions.group_name)(dimension, tag, &mut text, status)
        })?;
        Ok(unsafe { self.take_string(text) })
    }

    /// Tags of the geometrical entities of a physical group.
    pub fn group_entities(&self, dimension: i32, tag: i32) -> Result<Vec<i32>, FfiError> {
        let (mut tags, mut length) = (ptr::null_mut(), 0);
        // SAFETY: as in entity_count.
        self.call("gmshModelGetEntitiesForPhysicalGroup", |status| unsafe {
            (self.functions.group_entities)(dimension, tag, &mut tags, &mut length, status)
        })?;
        Ok(unsafe { self.take_array(tags, length) })
    }

    /// Tag and position of every node of the model.
    pub fn nodes(&self) -> Result<Vec<(usize, [f64; 3])>, FfiError> {
        let (mut tags, mut tag_count) = (ptr::null_mut(), 0);
        let (mut positions, mut position_count) = (ptr::null_mut(), 0);
        let (mut parameters, mut parameter_count) = (ptr::null_mut(), 0);
        // SAFETY: Gmsh stores three allocated arrays with their lengths, all freed below.
        self.call("gmshModelMeshGetNodes", |status| unsafe {
            (self.functions.nodes)(
                &mut tags,
                &mut tag_count,
                &mut positions,
                &mut position_count,
                &mut parameters,
                &mut parameter_count,
                -1,
                -1,
                0,
                0,
                status,
            )
        })?;
        let tags = unsafe { self.take_array(tags, tag_count) };
        let positions = unsafe { self.take_array(positions, position_count) };
        unsafe { self.take_array(parameters, parameter_count) };
        let positions = positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]);
        Ok(tags.into_iter().zip(positions).collect())
    }

    /// The elements of a geometrical entity.
    pub fn elements(&self, dimension: i32, entity: i32) -> Result<Vec<ElementBlock>, FfiError> {
        let (mut kinds, mut kind_count) = (ptr::null_mut(), 0);
        let (mut tags, mut tag_counts, mut tag_lists) = (ptr::null_mut(), ptr::null_mut(), 0);
        let (mut nodes, mut node_counts, mut node_lists) = (ptr::null_mut(), ptr::null_mut(), 0);
        // SAFETY: Gmsh stores one array of types and two arrays of arrays, all freed below.
        self.call("gmshModelMeshGetElements", |status| unsafe {
            (self.functions.elements)(
                &mut kinds,
                &mut kind_count,
                &mut tags,
                &mut tag_counts,
                &mut tag_lists,
                &mut nodes,
                &mut node_counts,
                &mut node_lists,
                dimension,
                entity,
                status,
            )
        })?;
        let kinds = unsafe { self.take_array(kinds, kind_count) };
        let tags = unsafe { self.take_arrays(tags, tag_counts, tag_lists) };
        let nodes = unsafe { self.take_arrays(nodes, node_counts, node_lists) };
        let blocks = kinds.into_iter().zip(tags).zip(nodes);
        Ok(blocks
            .map(|((kind, tags), nodes)| ElementBlock { kind, tags, nodes })
            .collect())
    }

    pub fn element_properties(&self, kind: i32) -> Result<ElementProperties, FfiError> {
        let mut name = ptr::null_mut();
        let (mut dimension, mut order, mut node_count, mut corner_count) = (0, 0, 0, 0);
        let (mut local, mut local_count) = (ptr::null_mut(), 0);
        // SAFETY: Gmsh stores numbers, an allocated C string and an array, both freed below.
        self.call("gmshModelMeshGetElementProperties", |status| unsafe {
            (self.functions.element_properties)(
                kind,
                &mut name,
                &mut dimension,
                &mut order,
                &mut node_count,
                &mut local,
                &mut local_count,
                &mut corner_count,
                status,
            )
        })?;
        unsafe { self.take_array(local, local_count) };
        Ok(ElementProperties {
            name: unsafe { self.take_string(name) },
            order: usize::try_from(order).unwrap_or(0),
            node_count: usize::try_from(node_count).unwrap_or(0),
        })
    }

    /// The number that a variable of the script holds; None for lists, texts and unknown names.
    pub fn variable(&self, name: &str) -> Option<f64> {
        let get = self.variables.as_ref()?.numbers;
        let name = CString::new(name).ok()?;
        let (mut values, mut length) = (ptr::null_mut(), 0);
        // SAFETY: a C string that outlives the call; Gmsh stores an allocated array and its length.
        self.call("gmshParserGetNumber", |status| unsafe {
            get(name.as_ptr(), &mut values, &mut length, status)
        })
        .ok()?;
        match unsafe { self.take_array(values, length) }.as_slice() {
            [value] => Some(*value),
            _ => None,
        }
    }

    /// The text that a variable of the script holds; None for lists, numbers and unknown names.
    pub fn text_variable(&self, name: &str) -> Option<String> {
        let get = self.variables.as_ref()?.texts;
        let name = CString::new(name).ok()?;
        let (mut lines, mut length) = (ptr::null_mut(), 0);
        // SAFETY: as in log, and a C string that outlives the call.
        self.call("gmshParserGetString", |status| unsafe {
            get(name.as_ptr(), &mut lines, &mut length, status)
        })
        .ok()?;
        let lines = unsafe { self.take_array(lines, length) };
        let mut texts = lines
            .into_iter()
            .map(|line| unsafe { self.take_string(line) });
        let first = texts.next();
        // All are taken, since all have to be freed.
        (texts.count() == 0).then_some(first).flatten()
    }

    /// From here on Gmsh keeps its messages for [`Session::log`].
    pub fn start_log(&self) -> Result<(), FfiError> {
        // SAFETY: no argument but the status.
        self.call("gmshLoggerStart", |status| unsafe {
            (self.functions.logger_start)(status)
        })
    }

    /// The messages since [`Session::start_log`], each led by its level, such as "Error: ".
    pub fn log(&self) -> Result<Vec<String>, FfiError> {
        let (mut lines, mut length) = (ptr::null_mut(), 0);
        // SAFETY: Gmsh stores an allocated array of allocated C strings, all freed here.
        self.call("gmshLoggerGet", |status| unsafe {
            (self.functions.logger_get)(&mut lines, &mut length, status)
        })?;
        let lines = unsafe { self.take_array(lines, length) };
        Ok(lines
            .into_iter()
            .map(|line| unsafe { self.take_string(line) })
            .collect())
    }

    fn call(&self, function: &'static str, run: impl FnOnce(Status)) -> Result<(), FfiError> {
        let mut code = 0;
        run(&mut code);
        if code == 0 {
            return Ok(());
        }
        Err(FfiError::Call {
            function,
            code,
            message: self.last_error(),
        })
    }

    fn last_error(&self) -> String {
        let (mut text, mut code) = (ptr::null_mut(), 0);
        // SAFETY: as in version; without a message the pointer stays null.
        unsafe {
            (self.functions.last_error)(&mut text, &mut code);
            self.take_string(text)
        }
    }

    /// Copies an array that Gmsh allocated, and frees it.
    ///
    /// # Safety
    /// `array` is null or comes from Gmsh, holds `length` values, and is not used again.
    unsafe fn take_array<T: Copy>(&self, array: *mut T, length: usize) -> Vec<T> {
        if array.is_null() {
            return Vec::new();
        }
        unsafe {
            let copy = std::slice::from_raw_parts(array, length).to_vec();
            (self.functions.free)(array.cast());
            copy
        }
    }

    /// Copies an array of arrays that Gmsh allocated, and frees all of it.
    ///
    /// # Safety
    /// As for `take_array`, for both levels; `lengths` holds the inner arrays' lengths.
    unsafe fn take_arrays<T: Copy>(
        &self,
        arrays: *mut *mut T,
        lengths: *mut usize,
        count: usize,
    ) -> Vec<Vec<T>> {
        let arrays = unsafe { self.take_array(arrays, count) };
        let lengths = unsafe { self.take_array(lengths, count) };
        let pairs = arrays.into_iter().zip(lengths);
        pairs
            .map(|(array, length)| unsafe { self.take_array(array, length) })
            .collect()
    }

    /// Copies a C string that Gmsh allocated, and frees it.
    ///
    /// # Safety
    /// `text` is null or a C string from Gmsh, and is not used again.
    unsafe fn take_string(&self, text: *mut c_char) -> String {
        if text.is_null() {
            return String::new();
        }
        unsafe {
            let copy = CStr::from_ptr(text).to_string_lossy().into_owned();
            (self.functions.free)(text.cast());
            copy
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let mut status = 0;
        // SAFETY: no argument but the status, which tells nothing of use at this point.
        unsafe { (self.functions.finalize)(&mut status) };
        SESSION_OPEN.store(false, Ordering::SeqCst);
    }
}

/// Ends the process at once, without the exit handlers: these would take down Gmsh's data while
/// another thread is in the midst of meshing.
pub fn exit_now(code: i32) -> ! {
    unsafe extern "C" {
        fn _exit(code: c_int) -> !;
    }
    // SAFETY: ends the process, whatever its state.
    unsafe { _exit(code) }
}
