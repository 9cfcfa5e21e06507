// The field on the device: columns of values. The size of a binding is limited, so columns lie in pages, each in a
// separate binding: a line that starts with `#each` is repeated once per page, with its number for PAGE.
//
// Of a large field, only the columns that rays can read are uploaded.
#import params

override PAGES: u32 = 1u;
// Otherwise every cell has a column with the cell's number.
override HAS_PLACES: bool = false;

// The numbers of cells' columns.
@group(0) @binding(6) var<storage, read> places: array<u32>;
#each @group(1) @binding(PAGE) var<storage, read> field_PAGE: array<f32>;

// Offset of a column.
struct Base {
    page: u32,
    first: u32,
}

fn pages_base(cell: u32) -> Base {
    var number = cell;
    if HAS_PLACES {
        number = places[cell];
    }
    var page = 0u;
    if PAGES > 1u {
        page = number / params.page_columns;
        number -= page * params.page_columns;
    }
    return Base(page, number * params.column_stride);
}

// Of a field without its lowest or highest layers, a missing one has the values of the next existing one: both are in
// one clear span, with all between them.
fn pages_at(base: Base, layer: u32) -> u32 {
    let row = clamp(layer, params.first_layer, params.last_layer) - params.first_layer;
    return base.first + row * params.layer_stride;
}

fn pages_get(base: Base, layer: u32) -> f32 {
    let at = pages_at(base, layer);
    if PAGES == 1u {
        return field_0[at];
    }
    switch base.page {
#each         case PAGEu: { return field_PAGE[at]; }
        default: { return 0.0; }
    }
}
