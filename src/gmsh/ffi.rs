//! The C API of Gmsh, loaded at run time. Apart from one call of METIS in [`crate::linear_solver`], the
//! only unsafe code of the crate.
//!
//! One binary serves Gmsh 4.8 to 4.15. Of the functions used here only `gmshInitialize` differs:
//! it gained an argument in the same release that brought the symbol `gmshIsInitialized`.
//! Gmsh's state belongs to the process and is not thread-safe; a [`Session`] is therefore unique in
//! its process and stays in its thread. No pointer leaves this file, every status is checked, and
//! all that Gmsh allocates goes back to `gmshFree`.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int};
use std::marker::PhantomData;
use std::mem::ManuallyDrop;
use std::path::Path;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};

use libloading::Library;

use super::ffi_types::{ElementBlock, ElementProperties, FfiError};
use functions::{Functions, Initialize, Status, Variables};

mod copies;
mod functions;

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
        // SAFETY: Gmsh stores a C string that it has allocated.
        unsafe {
            self.text("gmshOptionGetString", |text, status| {
                (self.functions.get_string)(c"General.Version".as_ptr(), text, status)
            })
        }
    }

    pub fn generate(&self, dimension: i32) -> Result<(), FfiError> {
        // SAFETY: plain numbers.
        self.call("gmshModelMeshGenerate", |status| unsafe {
            (self.functions.generate)(dimension, status)
        })
    }

    /// Tags of the geometrical entities of a dimension.
    pub fn entities(&self, dimension: i32) -> Result<Vec<i32>, FfiError> {
        // SAFETY: Gmsh stores an array that it has allocated, and its length.
        let pairs = unsafe {
            self.array("gmshModelGetEntities", |pairs, length, status| {
                (self.functions.entities)(pairs, length, dimension, status)
            })
        }?;
        Ok(pairs.chunks_exact(2).map(|pair| pair[1]).collect())
    }

    /// Dimension and tag of every physical group.
    pub fn groups(&self) -> Result<Vec<(i32, i32)>, FfiError> {
        // SAFETY: as in entities.
        let pairs = unsafe {
            self.array("gmshModelGetPhysicalGroups", |pairs, length, status| {
                (self.functions.groups)(pairs, length, -1, status)
            })
        }?;
        Ok(pairs.chunks_exact(2).map(|p| (p[0], p[1])).collect())
    }

    /// The name of a physical group; empty if it has none.
    pub fn group_name(&self, dimension: i32, tag: i32) -> Result<String, FfiError> {
        // SAFETY: as in version.
        unsafe {
            self.text("gmshModelGetPhysicalName", |text, status| {
                (self.functions.group_name)(dimension, tag, text, status)
            })
        }
    }

    /// Tags of the geometrical entities of a physical group.
    pub fn group_entities(&self, dimension: i32, tag: i32) -> Result<Vec<i32>, FfiError> {
        // SAFETY: as in entities.
        unsafe {
            self.array(
                "gmshModelGetEntitiesForPhysicalGroup",
                |tags, length, status| {
                    (self.functions.group_entities)(dimension, tag, tags, length, status)
                },
            )
        }
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
        // SAFETY: as in entities, and a C string that outlives the call.
        let values = unsafe {
            self.array("gmshParserGetNumber", |values, length, status| {
                get(name.as_ptr(), values, length, status)
            })
        };
        match values.ok()?.as_slice() {
            [value] => Some(*value),
            _ => None,
        }
    }

    /// The text that a variable of the script holds; None for lists, numbers and unknown names.
    pub fn text_variable(&self, name: &str) -> Option<String> {
        let get = self.variables.as_ref()?.texts;
        let name = CString::new(name).ok()?;
        // SAFETY: as in log, and a C string that outlives the call.
        let lines = unsafe {
            self.array("gmshParserGetString", |lines, length, status| {
                get(name.as_ptr(), lines, length, status)
            })
        };
        let mut texts = unsafe { self.take_strings(lines.ok()?) };
        (texts.len() == 1).then(|| texts.remove(0))
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
        // SAFETY: Gmsh stores an array of C strings, all of which it has allocated.
        let lines = unsafe {
            self.array("gmshLoggerGet", |lines, length, status| {
                (self.functions.logger_get)(lines, length, status)
            })
        }?;
        Ok(unsafe { self.take_strings(lines) })
    }

    /// Calls a function that delivers an array.
    ///
    /// # Safety
    /// The function stores an array that Gmsh has allocated, and its length.
    unsafe fn array<T: Copy>(
        &self,
        function: &'static str,
        run: impl FnOnce(*mut *mut T, *mut usize, Status),
    ) -> Result<Vec<T>, FfiError> {
        let (mut values, mut length) = (ptr::null_mut(), 0);
        self.call(function, |status| run(&mut values, &mut length, status))?;
        Ok(unsafe { self.take_array(values, length) })
    }

    /// Calls a function that delivers a text.
    ///
    /// # Safety
    /// The function stores a C string that Gmsh has allocated.
    unsafe fn text(
        &self,
        function: &'static str,
        run: impl FnOnce(*mut *mut c_char, Status),
    ) -> Result<String, FfiError> {
        let mut text = ptr::null_mut();
        self.call(function, |status| run(&mut text, status))?;
        Ok(unsafe { self.take_string(text) })
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
