//! What scenes of more than one volume show of fields f and g with values from -1 to 1, on layers up to 20 km.

pub const ONE: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-1, 1], \
    opacity = [[-1, 0.6], [-0.2, 0.05], [0.1, 0.0], [0.6, 0.7], [1, 0.3]] }\n";
pub const THIN: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"turbo\", range = [-1, 1], \
    opacity = [[-0.5, 0.0], [-0.4, 0.8], [-0.3, 0.0], [0.3, 0.0], [0.5, 0.9]] }\n";
pub const OTHER: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [-0.9, 0.9], \
    opacity = [[-0.6, 0.7], [-0.3, 0.0], [0.2, 0.0], [0.7, 0.95]] }\n";
pub const DENSE: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [-0.9, 0.9], \
    opacity = [[-0.6, 0.9999], [0.1, 0.0], [0.7, 0.9999]], unit_length = 1e-3 }\n";
pub const STEPS: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { knots = [ \
    { value = -0.9, color = \"blue\", opacity = 0.9 }, { value = -0.4, color = \"blue\", opacity = 0.9 }, \
    { value = -0.4, color = \"white\", opacity = 0 }, { value = 0.2, color = \"white\", opacity = 0 }, \
    { value = 0.2, color = \"yellow\", opacity = 0.6 }, { value = 0.9, color = \"red\", opacity = 0.99 } ] }\n";
pub const BY_OTHER: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-1, 1] }\n\
    opacity = { field = \"g\", values = [[-0.6, 0.7], [-0.3, 0.0], [0.2, 0.0], [0.7, 0.95]] }\n";
pub const REGION: &str = "[[clip]]\nlon = [10, 70]\nlat = [-20, 45]\n";
pub const SHELL: &str = "[[clip]]\nheight_m = [4000, 11000]\ncut = \"outside\"\n";
pub const ISO: &str = "[[isosurfaces]]\nfield = \"g\"\nvalue = 0.1\ncolor_by = \"f\"\nopacity = 0.6\n\
    transfer = { map = \"viridis\", range = [-1, 1] }\n";
pub const OWN_ISO: &str = "[[isosurfaces]]\nfield = \"f\"\nvalues = [-0.35, 0.4]\ncolors = [\"red\", \"#4080ff\"]\n\
    opacity = 0.5\n";
pub const SURFACE: &str = "[[surfaces]]\nlayer = 3\nfield = \"g\"\nopacity = 0.5\n\
    transfer = { map = \"magma\", range = [-0.9, 0.9] }\n";
pub const HIGH: &str = "[[surfaces]]\nheight_m = 8000\ncolor = \"#80a060\"\nopacity = 0.4\n";
