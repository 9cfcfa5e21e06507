//! Fields of any size and offset, constant ones, rough ones, and missing values.

use super::{BLUE, Case, CaseMesh, RED, knot, wave};
use icoray::{Knot, OwnedReals, Result};

/// The plain case with `v·scale + offset` in place of each value v of field and transfer function.
fn scaled(mesh: &CaseMesh, scale: f64, offset: f64, double: bool, name: String) -> Result<Case> {
    let mut case = mesh.case("field", name)?;
    let values = mesh.sampled(&case, |d, x| wave(d, x) * scale + offset);
    case.values =
        if double { OwnedReals::F64(values) } else { OwnedReals::F32(values.into_iter().map(|v| v as f32).collect()) };
    for knot in &mut case.scene.volumes[0].transfer.knots {
        knot.value = knot.value * scale + offset;
    }
    Ok(case)
}

/// Scales, offsets, constants and fields that turn in every cell.
pub fn fields(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (scale, offset, text) in [
        (1e-30, 0.0, "scale 1e-30"),
        (1e30, 0.0, "scale 1e30"),
        (1.0, 1e6 + 1.0, "offset 1e6 + 1"),
        (1.0, -1e6, "offset -1e6"),
    ] {
        cases.push(scaled(mesh, scale, offset, false, format!("{text}, in f32"))?);
        cases.push(scaled(mesh, scale, offset, true, format!("{text}, in f64"))?);
    }
    cases.push(scaled(mesh, 1e280, -1e281, true, "scale 1e280, offset -1e281, in f64".into())?);
    let step = [knot(0.0, RED, 0.2), knot(0.3, RED, 0.2), knot(0.3, BLUE, 0.9), knot(1.0, RED, 0.0)];
    // 0.3 is no binary number: the values of field and knot must be equal.
    let single = f64::from(0.3f32);
    let exact = step.map(|k| Knot { value: if k.value == 0.3 { single } else { k.value }, ..k });
    let of = |name: &str, f: &dyn Fn(glam::DVec3, f64) -> f64| {
        let mut case = mesh.case("field", name)?.transfer(0.02, &exact);
        mesh.field(&mut case, f);
        Ok(case)
    };
    cases.push(of("constant", &|_, _| 0.5)?);
    cases.push(of("constant on a step", &|_, _| 0.3)?);
    cases.push(of("constant on a knot", &|_, _| 1.0)?);
    cases.push(of("constant on the first knot", &|_, _| 0.0)?);
    cases.push(of("flat at a step, above it elsewhere", &|d, x| wave(d, x).max(0.3))?);
    cases.push(of("flat at a step, below it elsewhere", &|d, x| wave(d, x).min(0.3))?);
    cases.push(of("layers on knots", &|_, x| if x < 0.5 { 0.3 } else { 1.0 })?);
    cases.push(of("up and down from layer to layer", &|_, x| {
        if (5.0 * x) as i32 % 2 == 0 { 0.0 } else { 1.0 }
    })?);
    let noise = |d: glam::DVec3, x: f64| (12345.678 * (d.x + 2.0 * d.y + 3.0 * d.z + x)).sin();
    cases.push(of("noise", &noise)?);
    cases.push(of("noise of 1e30 among a wave", &|d, x| if noise(d, x) > 0.9 { 1e30 } else { wave(d, x) })?);
    Ok(cases)
}

/// NaN, infinities and fill values, some and all.
pub fn missing(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let holes = |name: &str, fill: Option<f64>, marks: [f64; 3], every: usize| {
        let mut case = mesh.case("field", name)?;
        let OwnedReals::F32(values) = &mut case.values else { return Ok(case) };
        for (i, value) in values.iter_mut().step_by(every).enumerate() {
            *value = marks[i % 3] as f32;
        }
        case.fill = fill;
        Ok(case)
    };
    let (nan, up, down) = (f64::NAN, f64::INFINITY, f64::NEG_INFINITY);
    let fill = f64::from(-9.96921e36f32);
    Ok(vec![
        holes("NaN here and there", None, [nan; 3], 101)?,
        holes("infinities here and there", None, [up, down, up], 101)?,
        holes("fill values here and there", Some(fill), [fill; 3], 101)?,
        holes("NaN, infinity and fill, hollow", Some(fill), [nan, up, fill], 67)?.hollow(),
        holes("all missing", None, [nan, up, down], 1)?,
        holes("a fill value that is a usual one", Some(0.0), [0.0; 3], 53)?,
    ])
}
