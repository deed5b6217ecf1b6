//! The functions of Gmsh's C API that are called, and how they are found in the shared library.

use std::ffi::{c_char, c_int, c_void};

use libloading::Library;

pub(super) type Status = *mut c_int;

/// Declares the table of C functions and how it is filled from the shared library.
macro_rules! c_functions {
    ($($name:ident = $symbol:literal ($($argument:ty),*);)*) => {
        /// The C functions that are called.
        pub(super) struct Functions { $(pub $name: unsafe extern "C" fn($($argument),*),)* }

        impl Functions {
            /// # Safety
            /// The signatures below must be those of the library.
            pub unsafe fn load(library: &Library) -> Result<Functions, libloading::Error> {
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

/// `gmshInitialize`, in its two forms.
pub(super) enum Initialize {
    /// Without the argument `run`: before the symbol `gmshIsInitialized`.
    Four(InitializeFour),
    Five(InitializeFive),
}

impl Initialize {
    /// # Safety
    /// `library` must be Gmsh.
    pub unsafe fn load(library: &Library) -> Result<Initialize, libloading::Error> {
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
pub(super) struct Variables {
    pub numbers: GetNumbers,
    pub texts: GetTexts,
}

impl Variables {
    /// # Safety
    /// `library` must be Gmsh.
    pub unsafe fn load(library: &Library) -> Option<Variables> {
        Some(Variables {
            numbers: *unsafe { library.get(b"gmshParserGetNumber\0") }.ok()?,
            texts: *unsafe { library.get(b"gmshParserGetString\0") }.ok()?,
        })
    }
}
