//! Copies of what Gmsh has allocated; the originals go back to it.

use std::ffi::{CStr, c_char};

use super::Session;

impl Session {
    /// Copies C strings that Gmsh allocated, and frees them.
    ///
    /// # Safety
    /// Each must fulfil the conditions of `take_string`.
    pub(super) unsafe fn take_strings(&self, texts: Vec<*mut c_char>) -> Vec<String> {
        let take = |text| unsafe { self.take_string(text) };
        texts.into_iter().map(take).collect()
    }

    /// Copies an array that Gmsh allocated, and frees it.
    ///
    /// # Safety
    /// `array` is null or comes from Gmsh, holds `length` values, and is not used again.
    pub(super) unsafe fn take_array<T: Copy>(&self, array: *mut T, length: usize) -> Vec<T> {
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
    /// Both levels must fulfil the conditions of `take_array`; `lengths` holds the inner arrays' lengths.
    pub(super) unsafe fn take_arrays<T: Copy>(
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
    pub(super) unsafe fn take_string(&self, text: *mut c_char) -> String {
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
