//! Surfaces, isosurfaces, cuts and further volumes of a scene, in the shaders' form.

use crate::layout::{Clip, Scenery, SurfaceLayer, VolumeMap, halves, halves3, scenery as constants};
use crate::shader::Contents;
use icoray::device::{self, ClipRegion, ColorByField, FieldId, IsosurfacePaint, Job, Paint, SurfacePlace};

/// The contents of a job's picture, for which the shader needs code; `in_parts` if it traces fragments.
pub(crate) fn contents(job: &Job, in_parts: bool) -> Contents {
    Contents {
        scenery: job.scenery().is_some(),
        volumes: job.scenery().map_or(0, |scenery| scenery.volumes.len()),
        painted: in_parts && job.is_painted(),
        native: job.scenery().is_some_and(|scenery| scenery.native.is_some()),
    }
}

/// The transfer functions of several volumes, in the order of `maps` of `shaders/scenery.wgsl`.
fn volume_maps(scenery: &device::Scenery) -> impl Iterator<Item = Option<&device::VolumeMap>> {
    scenery.volumes.iter().flat_map(|volume| [Some(&volume.extinction), volume.color.as_ref()])
}

/// The steps of the transfer functions of several volumes.
pub(crate) fn volume_steps<'j>(job: &'j Job) -> impl Iterator<Item = &'j device::Step> {
    job.scenery().into_iter().flat_map(volume_maps).flatten().flat_map(|map| &map.steps)
}

/// The spans of the transfer functions of several volumes.
pub(crate) fn volume_spans<'j>(job: &'j Job) -> impl Iterator<Item = &'j device::Span> {
    job.scenery().into_iter().flat_map(volume_maps).flatten().flat_map(|map| &map.spans)
}

/// The spans of the transfer functions of surfaces, in the order of their materials, then those of several volumes.
pub(crate) fn scenery_spans<'j>(job: &'j Job) -> impl Iterator<Item = &'j device::Span> {
    let layers = job.scenery().into_iter().flat_map(|scenery| &scenery.surface_layers);
    let of_layers = layers.flat_map(|layer| &layer.materials).flat_map(|material| match &material.paint {
        Paint::Plain(_) => [].as_slice(),
        Paint::Field { spans, .. } | Paint::Between(ColorByField { spans, .. }) => spans,
    });
    let isosurfaces = job.scenery().into_iter().flat_map(|scenery| &scenery.isosurfaces);
    let of_surfaces = of_layers.chain(isosurfaces.flat_map(|surface| match &surface.paint {
        IsosurfacePaint::Plain(_) => [].as_slice(),
        IsosurfacePaint::Field(colors) => &colors.spans,
    }));
    of_surfaces.chain(job.scenery().into_iter().flat_map(volume_maps).flatten().flat_map(|map| &map.spans))
}

/// The scenery of a job and the values of its surfaces.
pub(crate) struct SceneTables {
    pub scenery: Scenery,
    pub values: Vec<f32>,
}

impl SceneTables {
    pub fn new(job: &Job, shown: &device::Scenery) -> Self {
        let mut scenery = Scenery {
            clip_count: shown.clips.len() as u32,
            surface_layer_count: shown.surface_layers.len() as u32,
            seen_above: job.sees_above(),
            ..Scenery::default()
        };
        scenery.clips.iter_mut().zip(&shown.clips).for_each(|(clip, region)| *clip = clip_of(region));
        let number = |field: FieldId| field.map_or(constants::OWN_FIELD, |number| number as u32);
        let (mut all, mut materials) = (Vec::new(), scenery.materials.iter_mut());
        let (mut first_material, mut first_span) = (0, job.spans().len() as u32);
        for (layer, surface) in scenery.surface_layers.iter_mut().zip(&shown.surface_layers) {
            let material_count = surface.materials.len() as u32;
            let is_painted = u32::from(surface.is_painted);
            *layer = SurfaceLayer { first_material, material_count, is_painted, ..SurfaceLayer::default() };
            match surface.place {
                SurfacePlace::Layer(number) => layer.layer = number as u32,
                SurfacePlace::Radius(radius) => {
                    (layer.layer, layer.radius) = (constants::AT_RADIUS, halves(radius));
                    scenery.sphere_count += 1;
                }
            }
            first_material += material_count;
            for (shown, material) in surface.materials.iter().zip(materials.by_ref()) {
                material.opacity = shown.opacity;
                match &shown.paint {
                    Paint::Plain(color) => (material.color, material.kind) = (*color, constants::MATERIAL_PLAIN),
                    Paint::Field { spans, values, by_cell } => {
                        material.kind = if *by_cell { constants::MATERIAL_CELLS } else { constants::MATERIAL_FIELD };
                        (material.first_value, material.first_span) = (all.len() as u32, first_span);
                        material.span_count = spans.len() as u32;
                        first_span += material.span_count;
                        all.extend_from_slice(values);
                    }
                    Paint::Between(colors) => {
                        (material.kind, material.field) = (constants::MATERIAL_BETWEEN, number(colors.field));
                        (material.first_span, material.span_count) = (first_span, colors.spans.len() as u32);
                        [material.scale, material.shift] = colors.to_spans;
                        first_span += material.span_count;
                    }
                }
            }
        }
        scenery.isosurface_count = shown.isosurfaces.len() as u32;
        for (surface, shown) in scenery.isosurfaces.iter_mut().zip(&shown.isosurfaces) {
            (surface.opacity, surface.value, surface.field) = (shown.opacity, shown.value, number(shown.field));
            match &shown.paint {
                IsosurfacePaint::Plain(color) => (surface.color, surface.kind) = (*color, constants::MATERIAL_PLAIN),
                IsosurfacePaint::Field(colors) => {
                    (surface.kind, surface.color_field) = (constants::MATERIAL_FIELD, number(colors.field));
                    (surface.first_span, surface.span_count) = (first_span, colors.spans.len() as u32);
                    [surface.scale, surface.shift] = colors.to_spans;
                    first_span += surface.span_count;
                }
            }
        }
        scenery.volume_count = shown.volumes.len() as u32;
        let mut first_step = job.steps().len() as u32;
        for (map, shown) in scenery.maps.iter_mut().zip(volume_maps(shown)) {
            let Some(shown) = shown else { continue };
            let (span_count, step_count) = (shown.spans.len() as u32, shown.steps.len() as u32);
            let field = number(shown.field);
            *map = VolumeMap { field, first_span, span_count, first_step, step_count, padding: [0; 3] };
            (first_span, first_step) = (first_span + span_count, first_step + step_count);
        }
        for (field, shown) in scenery.fields.iter_mut().zip(&shown.fields) {
            field.first_value = all.len() as u32;
            all.extend_from_slice(&shown.values);
            field.first_gradient = all.len() as u32;
            all.extend_from_slice(shown.gradients.as_flattened());
        }
        if let Some(native) = &shown.native {
            scenery.first_inverse = all.len() as u32;
            all.extend(native.inverse.iter().copied().flat_map(halves));
            [scenery.core_low, scenery.core_high] = native.core_radius.map(halves);
            scenery.outer = halves(native.outer);
            for (layer, normals) in &native.normals {
                let first = all.len() as u32;
                all.extend_from_slice(normals.as_flattened());
                if *layer == 0 {
                    scenery.core_normal = first;
                }
                let on_layer = scenery.surface_layers.iter_mut().filter(|surface| surface.layer == *layer as u32);
                on_layer.for_each(|surface| surface.first_normal = first);
            }
        }
        SceneTables { scenery, values: all }
    }
}

fn clip_of(region: &ClipRegion) -> Clip {
    let [first, last] = region.layers.map_or([0, u32::MAX], |layers| layers.map(|layer| layer as u32));
    let cuts_inside = u32::from(region.cuts_inside);
    let mut clip = Clip { first_layer: first, last_layer: last, cuts_inside, ..Clip::default() };
    if let Some((towards, distance)) = region.half_space {
        clip.kind |= constants::HAS_HALF_SPACE;
        [clip.towards_hi, clip.towards_lo] = halves3(towards.to_array());
        [clip.distance_hi, clip.distance_lo] = halves(distance);
    }
    if let Some(shell) = region.shell {
        clip.kind |= constants::HAS_SHELL;
        [clip.inner, clip.outer] = shell.map(halves);
    }
    let Some(region) = region.region else { return clip };
    clip.kind |= constants::HAS_LATITUDES;
    // Beyond the poles, where rounding does not matter.
    let sine = |lat: f64| if lat.abs() < 90.0 { lat.to_radians().sin() } else { 2.0 * lat.signum() };
    [clip.south, clip.north] = region.lat_deg.map(|lat| halves(sine(lat)));
    let [west, east] = region.lon_deg;
    if east - west < 360.0 {
        clip.kind |= constants::HAS_LONGITUDES | if east - west > 180.0 { constants::IS_WIDE } else { 0 };
        [clip.west, clip.east] = region.lon_deg.map(|lon| {
            let [[x, x_lo], [y, y_lo]] = [-lon.to_radians().sin(), lon.to_radians().cos()].map(halves);
            [x, y, x_lo, y_lo]
        });
    }
    clip
}
