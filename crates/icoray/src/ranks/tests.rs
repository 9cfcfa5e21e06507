//! Ranks that are threads: the same picture to the bit, and the same error on all.

use super::*;
use crate::common::{FAR, Model, at_centers, bits, even_heights, on_nodes, on_ranks, over_columns, pictures};
use crate::fields::Fields;
use crate::raster::{Pixel, Raster, Tile, Tiling};
use crate::render::Renderer;
use crate::spread::Rows;
use icoray_grid::threads::Threads;
use icoray_grid::{ErrorKind, Field, Grid, IcosahedralMesh, Layers};
use icoray_kernel::Counts;
use icoray_output::{Frame, FrameReport};
use icoray_scene::{Scene, Volume};
use icoray_test_support::PATIENCE;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::thread;
use std::time::Instant;

mod schedules;
mod votes;

const LAYERS: usize = 3;

fn model() -> Model {
    let value = |cell: usize, layer: usize| ((cell * LAYERS + layer) as f64 * 0.37).sin() + layer as f64;
    Model::new(3, &even_heights(LAYERS, 20e3 / 6.371e6), |cell, _, layer| [value(cell, layer)])
}

/// A scene in which `more` has further keys and, behind a bar, further tables.
fn scene(width: u32, height: u32, more: &str) -> Scene {
    let transfer = "map = \"viridis\"\nrange = [-1, 3]\nopacity = [[-1, 0.8], [0, 0.1], [3, 0.9]]";
    let keys = format!("exaggeration = 40\nimage = {{ width = {width}, height = {height} }}\n{more}");
    crate::common::scene(FAR, transfer, &keys)
}

/// Two frames over `size` ranks: dealt blindly, then by cost. The picture, and the reports of all.
fn together(model: &Model, scene: &Scene, size: usize) -> [(Frame, Vec<FrameReport>); 2] {
    pictures(on_ranks(size, |ranks| {
        let renderer = Renderer::new(1 + ranks.rank() % 2).unwrap();
        [(); 2].map(|()| model.draw_over(&renderer, scene, ranks).unwrap())
    }))
}

#[test]
fn a_shared_picture_is_that_of_one_to_the_bit() {
    let model = model();
    for (width, height, more) in
        [(97, 61, ""), (64, 64, "|[light]\nkind = \"headlight\""), (1, 1, ""), (5, 90, "precision = \"f64\"")]
    {
        let scene = scene(width, height, more);
        let one = model.draw(&scene);
        assert_eq!((one.report.ranks.count, one.report.ranks.bytes_received), (1, 0));
        for size in [1, 2, 3, 4, 8] {
            for (frame, reports) in together(&model, &scene, size) {
                assert_eq!(bits(&frame), bits(&one), "{width} x {height} over {size} ranks");
                let report = &frame.report;
                assert_eq!((report.ranks.count, reports.len()), (size, size));
                assert_eq!((report.counts, report.error), (one.report.counts, one.report.error));
                let balance = report.ranks.balance;
                assert!(balance > 0.0 && balance <= 1.0 + 1e-9, "{balance}");
                let tiles = reports.iter().map(|report| report.ranks.tiles).sum::<usize>();
                assert_eq!(tiles, one.report.ranks.tiles);
                for other in &reports {
                    assert_eq!((other.counts, other.error), (report.counts, report.error));
                    assert_eq!(other.ranks.bytes_received, report.ranks.bytes_received);
                }
                let is_sent = size > 1 && one.report.ranks.tiles > 1;
                assert!(!is_sent || report.ranks.bytes_received > 0);
                // A tile off the globe is one pixel.
                let all = (width * height) as usize * size_of::<[f32; 5]>();
                let most = all + 128 * tiles + 64 * size;
                assert!((report.ranks.bytes_received as usize) < most);
            }
        }
    }
}

#[test]
fn within_a_budget_all_ranks_draw_the_quality_of_rank_0() {
    let model = model();
    let scene = scene(600, 400, "time_budget_ms = 1|[light]\nkind = \"headlight\"");
    for (frame, reports) in together(&model, &scene, 3) {
        assert!(frame.report.quality.pixel_step > 1, "{}", frame.report.quality);
        assert!(reports.iter().all(|report| report.quality == frame.report.quality));
        assert_eq!(frame.pixels.len(), 600 * 400);
    }
}

/// The error of each rank, if rank `odd` draws the model and the scene modified by `spoil`.
fn errors(odd: usize, spoil: impl Fn(&mut Model, &mut Scene) + Sync) -> Vec<String> {
    on_ranks(3, |ranks| {
        let (good, mut data, mut of) = (model(), model(), scene(70, 40, ""));
        if ranks.rank() == odd {
            spoil(&mut data, &mut of);
        }
        let renderer = Renderer::new(1).unwrap();
        let field = at_centers(&data.values[0], LAYERS);
        let error = renderer.render_over(ranks, &of, &data.grid, &data.layers, &field).unwrap_err().to_string();
        // The next frame is drawn as if nothing had been.
        good.draw_over(&renderer, &scene(70, 40, ""), ranks).unwrap();
        error
    })
}

#[test]
fn an_error_on_one_rank_is_the_error_of_all() {
    for odd in 0..3 {
        let same = |errors: &[String], start: &str| {
            assert!(errors.iter().all(|e| *e == errors[0] && e.starts_with(start)), "{errors:?}");
        };
        let few = |model: &mut Model, _: &mut Scene| model.values[0].truncate(162 * LAYERS);
        same(&errors(odd, few), &format!("bad field: rank {odd}: \"f\": 162 columns"));
        let inside = |_: &mut Model, scene: &mut Scene| scene.exaggeration = -1e3;
        same(&errors(odd, inside), &format!("bad scene: rank {odd}: "));
        // A rank with another value disagrees with rank 0; if rank 0 has it, rank 1 is the first to differ.
        let other = |model: &mut Model, _: &mut Scene| model.values[0][7] = 40.0;
        same(&errors(odd, other), &format!("MPI: rank {}: {HAS_WHOLE} \"f\" with values of hash ", odd.max(1)));
        let higher = |model: &mut Model, _: &mut Scene| {
            model.layers = Layers::from_heights(&even_heights(LAYERS, 21e3 / 6.371e6), 1.0).unwrap();
        };
        same(&errors(odd, higher), &format!("MPI: rank {}: has layers", odd.max(1)));
    }
}

/// Data of the same sizes and ranges: the tiles that a rank draws from them would not fit those of the others.
#[test]
fn ranks_with_other_tables_or_values_draw_no_picture() {
    const TEXT: &str = "heights = \"native\"|[[derive]]\nname = \"d\"\nsum = { t = 1, u = 2 }";
    let model = model();
    let heights = over_columns(model.grid.cells(), LAYERS, |cell, layer| 1e4 * layer as f64 + cell as f64);
    type Change = fn(&mut IcosahedralMesh, &mut [Vec<f32>; 4], &mut Vec<f64>);
    let cases: [(Change, Option<&str>); 9] = [
        (|_, _, _| (), None),
        // 0 and -0, and all NaN, are one.
        (|_, [f, ..], _| (f[5], f[8]) = (-0.0, f32::from_bits(f32::NAN.to_bits() ^ 5)), None),
        (
            |mesh, _, _| mesh.lon_center_rad.iter_mut().for_each(|lon| *lon = (*lon + 0.5) % TAU),
            Some("table center of hash "),
        ),
        (|mesh, _, _| mesh.corner_edge[..3].rotate_left(1), Some("table corner_edge of hash ")),
        (|_, [f, ..], _| f.reverse(), Some("\"f\" with values of hash ")),
        (|_, [_, t, ..], _| t.swap(0, 30), Some("\"d\" with values of hash ")),
        (|_, [.., v], _| v.reverse(), Some("\"v\" with values of hash ")),
        (|_, [_, _, u, _], _| u.reverse(), Some("\"d\" with values of hash ")),
        (|_, _, heights| heights[3..9].rotate_left(3), Some("\"heights\" with values of hash ")),
    ];
    for (change, differs) in cases {
        for scheme in ["tiles", "fragments"] {
            let outcomes = on_ranks(3, |ranks| {
                let mut mesh = IcosahedralMesh::new(3).unwrap();
                let times = |factor: f32| model.values[0].iter().map(|value| factor * value).collect::<Vec<f32>>();
                let (mut fields, mut heights) = ([1.0, -1.0, 0.2, 0.5].map(times), heights.clone());
                (fields[0][5], fields[0][8]) = (0.0, f32::NAN);
                if ranks.rank() == 1 {
                    change(&mut mesh, &mut fields, &mut heights);
                }
                let grid = Grid::new(mesh.tables()).unwrap();
                let [f, t, u, v] = fields.each_ref().map(|values| at_centers(values, LAYERS));
                let fields = Fields::new([("f", f), ("t", t), ("u", u), ("v", v)]);
                let fields = fields.with_heights(at_centers(&heights, LAYERS));
                let mut scene = scene(60, 40, &format!("ranks = \"{scheme}\"\n{TEXT}"));
                for field in ["d", "v"] {
                    scene.volumes.push(Volume { field: field.into(), ..scene.volumes[0].clone() });
                }
                let rendered = Renderer::new(1).unwrap().render_over(ranks, &scene, &grid, &model.layers, fields);
                rendered.map(drop).map_err(|error| error.to_string())
            });
            let is_expected = |outcome: &std::result::Result<(), String>| match (differs, outcome) {
                (None, outcome) => outcome.is_ok(),
                (Some(part), outcome) => {
                    outcome.as_ref().is_err_and(|e| e.starts_with("MPI: rank 1: has ") && e.contains(part))
                }
            };
            assert!(outcomes.iter().all(is_expected), "{outcomes:?}, expected {differs:?}");
        }
    }
}

/// The tiles of a raster, each of which a rank owns.
fn share<'t>(raster: &'t Raster, owners: &'t [u32]) -> TileShare<'t> {
    TileShare { tiling: raster, owners, earlier_s: 0.0, earlier_counts: Counts::default() }
}

#[test]
fn tiles_are_on_their_way_while_others_are_drawn() {
    let raster = Raster { width: 20, height: 4, step: 1 };
    let taken = Arc::new(AtomicUsize::new(0));
    let team = local_nodes_over(&[0; 2], |messages| Counted { messages, taken: taken.clone() });
    on_threads(team, |team| {
        let ranks = &mut Ranks::new(team);
        let rank = ranks.rank();
        let threads = Threads::new(1).unwrap();
        let tile = |number: u32| {
            let pixels = vec![Pixel::default(); raster.pixels_of(number)];
            Tile { number, seconds: 0.0, counts: Counts::default(), pixels }
        };
        let owners: Vec<u32> = (0..raster.tiles()).map(|number| number % 2).collect();
        let messages = owners.iter().filter(|owner| **owner == 1).count();
        let (deadline, share) = (Instant::now() + PATIENCE, share(&raster, &owners));
        let gathered = ranks.gather(&threads, &share, |give| {
            (0..raster.tiles()).filter(|number| *number as usize % 2 == rank).for_each(|n| give(tile(n)));
            // Rank 0 draws until it has received all of rank 1's messages.
            while rank == 0 && taken.load(SeqCst) < messages {
                assert!(Instant::now() < deadline, "no message is received while tiles are drawn");
                thread::yield_now();
            }
        });
        assert_eq!(gathered.unwrap().tiles.len(), if rank == 0 { raster.tiles() as usize } else { 0 });
        ranks.hear_root(Ok(FrameSummary::default())).unwrap();
    });
}

/// Messages of which those are counted that were received.
struct Counted {
    messages: LocalMessages,
    taken: Arc<AtomicUsize>,
}

impl Messages for Counted {
    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.messages.send(to, bytes)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        let received = self.messages.try_receive()?;
        self.taken.fetch_add(usize::from(received.is_some()), SeqCst);
        Ok(received)
    }
}

#[test]
fn unreadable_messages_are_an_error_and_no_hang() {
    let raster = Raster { width: 20, height: 4, step: 1 };
    let threads = Threads::new(1).unwrap();
    let without_pixels = [&[1][..], &[0; 63]].concat();
    for odd in [&[][..], &[7; 8], &without_pixels[..9], &without_pixels, &[2; 3], &[1, 5]] {
        let outcomes = on_ranks(3, |ranks| {
            if ranks.rank() == 2 {
                ranks.team.as_mut().unwrap().send(odd.to_vec()).unwrap();
            }
            let summary = ranks.gather(&threads, &share(&raster, &[0, 2]), |_| ()).map(|_| FrameSummary::default());
            ranks.hear_root(summary).unwrap_err().to_string()
        });
        assert!(outcomes.iter().all(|e| *e == outcomes[0] && e.starts_with("MPI: rank 2: ")), "{outcomes:?}");
    }
}

/// For any number of columns sent at once: one, some, all.
#[test]
fn nodes_put_a_field_together_in_rounds() {
    let model = model();
    let (grid, values) = (&model.grid, &model.values[0]);
    let cells = grid.cells();
    for node_of in [&[0, 1, 0, 2, 1][..], &[0, 0, 0], &[0, 1, 2]] {
        on_nodes(node_of, |ranks| {
            let (rank, size) = (ranks.rank(), ranks.size());
            // Unevenly: the first has half of them.
            let is_own = |cell: usize| (cell % (2 * size)).saturating_sub(size) == rank;
            let all = Rows::new((0..cells).collect(), |cell| cell as i64, is_own);
            let columns = Columns::of_whole(ranks, grid, &all.cells(), None).unwrap();
            let (threads, layers) = (Threads::new(1).unwrap(), Layers::from_heights(&[0.0, 1.0], 6e6).unwrap());
            let inputs = GatherInputs { threads: &threads, grid, layers: &layers, derivation_inputs: Vec::new() };
            // Two of them, in other orders, and heights.
            let backwards: Vec<f32> = values.iter().rev().copied().collect();
            let heights: Vec<f64> = values.iter().map(|value| f64::from(*value) + 9.0).collect();
            let fields = [("a", at_centers(values, LAYERS)), ("b", at_centers(&backwards, LAYERS))];
            let fields = Fields::new(fields).with_heights(at_centers(&heights, LAYERS));
            for (most, is_refused) in [(1, false), (1, true), (1000, false), (1000, true), (usize::MAX / 2, false)] {
                let (targets, bytes) = columns.targets(&inputs, &fields).unwrap();
                assert_eq!(bytes, 2 * (4 * values.len()).next_multiple_of(8) + 8 * values.len());
                let mut node = ranks.take_node(bytes).unwrap();
                if is_refused {
                    // Ranks of the first node have their own memory.
                    node = match node_of[rank] {
                        0 => NodeMemory::alone(rank, bytes),
                        _ => ranks.team.as_mut().unwrap().node(bytes).unwrap(),
                    };
                    (node.is_shared, node.is_refused_here, node.is_refused) = (true, node_of[rank] == 0, true);
                }
                for target in &targets {
                    columns.gather_by(ranks, &inputs, &mut node, target, most).unwrap();
                }
                let gathered = NodeFields {
                    node,
                    mates: None,
                    grid: None,
                    stored: targets.into_iter().map(|target| target.whole).collect(),
                    heights_error: None,
                    bytes_copied: 0,
                    bytes_averaged: 0,
                    copy_s: 0.0,
                };
                let whole = gathered.fields().unwrap();
                let [a, b] = ["a", "b"].map(|name| whole.get(name).unwrap());
                let last = values.len() - 1;
                for (i, value) in values.iter().enumerate() {
                    let at = |field: &Field, i: usize| field.value(i / LAYERS, i % LAYERS);
                    let value = f64::from(*value);
                    assert_eq!([at(a, i), at(b, last - i)], [value; 2]);
                    assert_eq!(at(whole.heights().unwrap(), i), value + 9.0);
                }
                // Zeros would be seen if the next time did not write all.
                let mut node = gathered.node;
                node.begin(ranks.team.as_mut()).unwrap();
                node.put(0, &vec![0; if rank == 0 { 1000 } else { 0 }]);
                node.settle(ranks.team.as_mut()).unwrap();
                if !is_refused {
                    ranks.keep_node(node);
                }
            }
        });
    }
}

#[test]
fn processors_are_shared_by_the_ranks_of_a_node_whose_masks_overlap() {
    let sharing = |node_of: &[usize], masks: &[&[u8]]| {
        on_nodes(node_of, |ranks| ranks.sharing_processors(masks[ranks.rank()]).unwrap())
    };
    let (low, high, all) = (&[0x0f, 0][..], &[0xf0, 0][..], &[0xff, 0xff][..]);
    assert_eq!(sharing(&[0, 0, 0], &[all, all, all]), [3, 3, 3]);
    assert_eq!(sharing(&[0, 0, 0], &[low, high, low]), [2, 1, 2]);
    assert_eq!(sharing(&[0, 0, 0], &[low, high, all]), [2, 2, 3]);
    assert_eq!(sharing(&[0, 1, 0, 1], &[all, all, all, low]), [2, 2, 2, 2]);
    assert_eq!(sharing(&[0, 0], &[low, &[]]), [2, 2]);
    assert_eq!(Ranks::alone().sharing_processors(all).unwrap(), 1);
}

#[test]
fn the_members_of_a_group_have_the_bytes_of_all() {
    for size in 1..20 {
        for groups in 1..=size.min(4) {
            let shared = on_ranks(size, |ranks| {
                let rank = ranks.rank();
                let members = ranks.team.as_mut().unwrap().find_group(rank % groups, 3).unwrap();
                assert!(members.iter().copied().eq((rank % groups..size).step_by(groups)));
                let others = ranks.share_among(&members, vec![rank as u8; rank]).unwrap();
                others == members.iter().map(|member| vec![*member as u8; *member]).collect::<Vec<_>>()
            });
            assert!(shared.into_iter().all(|is_right| is_right), "{groups} groups of {size} ranks");
        }
    }
}

/// Memory that a node has beside other memory is separate from it, and keeps what its ranks wrote before.
#[test]
fn memories_of_a_node_are_separate() {
    on_local_nodes(&[0, 0, 1], |team| {
        let mut ranks = Ranks::new(team);
        let (mut one, mut other) = (ranks.take_node(8).unwrap(), ranks.take_node(8).unwrap());
        let place = [0, 4, 0][ranks.rank()];
        let mut write = |memory: &mut NodeMemory, bytes: &[u8]| {
            let put = |put: PutBytes| {
                put(place, bytes);
                Ok(())
            };
            memory.write(&mut ranks, put).unwrap();
        };
        write(&mut one, &[1; 4]);
        write(&mut other, &[2; 4]);
        write(&mut one, &[3]);
        let written = if ranks.rank() < 2 { [[3, 1, 1, 1]; 2].concat() } else { vec![3, 1, 1, 1] };
        assert_eq!(one.bytes()[..written.len()], written);
        assert!(other.bytes()[..written.len()].iter().all(|byte| *byte == 2));
    });
}
