//! Another Rust static library in a model's program, with a standard library of its own.

/// 1, as the panic is caught.
#[unsafe(no_mangle)]
pub extern "C" fn other_catches_a_panic() -> i32 {
    std::panic::set_hook(Box::new(|_| {}));
    i32::from(std::panic::catch_unwind(|| std::thread::spawn(|| panic!()).join().unwrap()).is_err())
}
