//! Nodes of Conduit, by functions that are found in the host's process.
//!
//! libcatalyst contains Conduit, under names that begin with `catalyst_`, or links an external one. The host's is found
//! at run time, so that this library is built without either.
//!
//! Behind its C interface Conduit is C++ and throws, and no exception may reach Rust. The conditions under which it
//! throws (a path that does not exist, a child beyond their number, a value of another type) are checked before each
//! call. Exhausted memory remains: C++ then ends the process, as Rust does where one of its own small allocations
//! fails. Reference: Conduit's C interface, `conduit_node.h` and `conduit_datatype.h`.

mod array;
mod symbols;

pub use array::{Array, NumberType};
pub use symbols::Symbols;

use std::ffi::{CStr, CString, c_char, c_int, c_void};

/// A node as C has it.
pub type RawNode = c_void;
/// Conduit's `conduit_index_t` as it is built by default.
type Index = i64;

macro_rules! functions {
    ($($name:ident($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Conduit's functions.
        #[derive(Clone, Copy)]
        pub struct Conduit {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Conduit {
            /// The functions whose names begin so.
            fn with_prefix(symbols: &Symbols, prefix: &str) -> Option<Self> {
                Some(Conduit {
                    // SAFETY: the function of that name has this type.
                    $($name: unsafe { std::mem::transmute::<
                        *mut c_void,
                        unsafe extern "C" fn($($argument),*) $(-> $result)?,
                    >(symbols.find(concat!("conduit_", stringify!($name)), prefix)?) },)*
                })
            }
        }
    };
}

functions! {
    node_has_path(*const RawNode, *const c_char) -> c_int;
    node_fetch_existing(*mut RawNode, *const c_char) -> *mut RawNode;
    node_number_of_children(*mut RawNode) -> Index;
    node_child(*mut RawNode, Index) -> *mut RawNode;
    node_name(*const RawNode) -> *mut c_char;
    node_dtype(*const RawNode) -> *const c_void;
    node_element_ptr(*mut RawNode, Index) -> *mut c_void;
    node_as_char8_str(*mut RawNode) -> *mut c_char;
    node_set_path_char8_str(*mut RawNode, *const c_char, *const c_char);
    node_set_path_int64(*mut RawNode, *const c_char, i64);
    node_set_path_float64(*mut RawNode, *const c_char, f64);
    datatype_id(*const c_void) -> Index;
    datatype_number_of_elements(*const c_void) -> Index;
    datatype_stride(*const c_void) -> Index;
    datatype_endianness_matches_machine(*const c_void) -> c_int;
}

/// Numbers of `conduit_datatype_id`.
const EMPTY: Index = 0;
const OBJECT: Index = 1;
const LIST: Index = 2;
const CHAR8_STR: Index = 13;

impl Conduit {
    /// The functions of the host's Conduit.
    pub fn find() -> Result<Self, String> {
        let symbols = Symbols::of_process();
        let found = ["catalyst_", ""].into_iter().find_map(|prefix| Conduit::with_prefix(&symbols, prefix));
        found.ok_or_else(|| {
            "the process has no functions of Conduit (looked for catalyst_conduit_node_dtype, conduit_node_dtype and the \
             others of its C interface)"
                .to_owned()
        })
    }
}

/// A node of the host's, alive for `'a`.
#[derive(Clone, Copy)]
pub struct Node<'a> {
    node: *mut RawNode,
    conduit: &'a Conduit,
}

impl<'a> Node<'a> {
    /// # Safety
    /// A node that lives, and is not changed by others, for `'a`.
    pub unsafe fn new(node: *const RawNode, conduit: &'a Conduit) -> Option<Self> {
        (!node.is_null()).then(|| Node { node: node.cast_mut(), conduit })
    }

    pub fn at(self, path: &str) -> Option<Node<'a>> {
        let path = CString::new(path).ok()?;
        // SAFETY: a node that lives and a string. Conduit throws where there is no such path, which was asked before.
        unsafe {
            if (self.conduit.node_has_path)(self.node, path.as_ptr()) == 0 {
                return None;
            }
            Node::new((self.conduit.node_fetch_existing)(self.node, path.as_ptr()), self.conduit)
        }
    }

    /// Whether it has neither children nor a value.
    pub fn is_empty(self) -> bool {
        self.id() == EMPTY || (self.has_children() && self.children().is_empty())
    }

    fn has_children(self) -> bool {
        [OBJECT, LIST].contains(&self.id())
    }

    /// The children of an object, with their names, or of a list; none of another node.
    pub fn children(self) -> Vec<(String, Node<'a>)> {
        if !self.has_children() {
            return Vec::new();
        }
        // SAFETY: a node that lives.
        let count = unsafe { (self.conduit.node_number_of_children)(self.node) };
        // SAFETY: one of its children, by a number below their count.
        let child = |i| unsafe { Node::new((self.conduit.node_child)(self.node, i), self.conduit) };
        (0..count).filter_map(child).map(|child| (child.name(), child)).collect()
    }

    fn name(self) -> String {
        // SAFETY: a node that lives; the name is a copy that the caller frees.
        unsafe {
            let name = (self.conduit.node_name)(self.node);
            if name.is_null() {
                return String::new();
            }
            let text = CStr::from_ptr(name).to_string_lossy().into_owned();
            libc::free(name.cast());
            text
        }
    }

    fn id(self) -> Index {
        // SAFETY: a node that lives.
        unsafe { (self.conduit.datatype_id)((self.conduit.node_dtype)(self.node)) }
    }

    pub fn text(self) -> Option<String> {
        if self.id() != CHAR8_STR {
            return None;
        }
        // SAFETY: a node that lives and is a string, which Conduit ends with NUL.
        unsafe {
            let text = (self.conduit.node_as_char8_str)(self.node);
            (!text.is_null()).then(|| CStr::from_ptr(text).to_string_lossy().into_owned())
        }
    }

    pub fn text_at(self, path: &str) -> Option<String> {
        self.at(path)?.text()
    }

    /// The first number of an array.
    pub fn number(self) -> Option<f64> {
        let array = self.array()?;
        (!array.is_empty()).then(|| array.real(0))
    }

    /// The first number of an array of integers.
    pub fn integer(self) -> Option<i64> {
        let array = self.array()?;
        (!array.is_empty() && array.kind().is_integer()).then(|| array.integer(0))
    }

    /// Numbers, in place; `None` for other nodes and for numbers of another machine's byte order.
    pub fn array(self) -> Option<Array<'a>> {
        let kind = NumberType::of_id(self.id())?;
        // SAFETY: a node of numbers that lives. Element 0 exists if there are any.
        unsafe {
            let dtype = (self.conduit.node_dtype)(self.node);
            let count = usize::try_from((self.conduit.datatype_number_of_elements)(dtype)).ok()?;
            let stride = (self.conduit.datatype_stride)(dtype) as isize;
            if (self.conduit.datatype_endianness_matches_machine)(dtype) == 0 {
                return None;
            }
            let data = if count == 0 { std::ptr::null_mut() } else { (self.conduit.node_element_ptr)(self.node, 0) };
            (count == 0 || !data.is_null()).then(|| Array::new(data.cast_const().cast(), kind, count, stride))
        }
    }

    /// Description of a node in messages: its type, or the names of its children.
    pub fn described(self) -> String {
        match self.text() {
            Some(text) => format!("{text:?}"),
            None if self.is_empty() => "empty".into(),
            None if self.has_children() => {
                let names: Vec<_> = self.children().into_iter().map(|(name, _)| name).collect();
                format!("an object with {}", names.join(", "))
            }
            None => self.array().map_or_else(
                || "no numbers of this machine".into(),
                |array| format!("{} numbers of type {}", array.len(), array.kind()),
            ),
        }
    }

    pub fn set_text(self, path: &str, text: &str) {
        if let (Ok(path), Ok(text)) = (CString::new(path), CString::new(text)) {
            // SAFETY: a node that the host gave to be filled, and strings, which Conduit copies.
            unsafe { (self.conduit.node_set_path_char8_str)(self.node, path.as_ptr(), text.as_ptr()) };
        }
    }

    pub fn set_integer(self, path: &str, value: i64) {
        if let Ok(path) = CString::new(path) {
            // SAFETY: as in `set_text`.
            unsafe { (self.conduit.node_set_path_int64)(self.node, path.as_ptr(), value) };
        }
    }

    pub fn set_number(self, path: &str, value: f64) {
        if let Ok(path) = CString::new(path) {
            // SAFETY: as in `set_text`.
            unsafe { (self.conduit.node_set_path_float64)(self.node, path.as_ptr(), value) };
        }
    }
}
