//! Pictures of many ranks: messages of the real exchange over a simulated network, and the work of nodes of large grids
//! by geometry.
//!
//! [`exchange`] renders frames of a small grid with a thread for each rank. All messages are the library's; a model of a
//! network gives their times ([`network`]). Rays take no time of it: the seconds are those of the exchange alone, from
//! rank 0's call to its picture. [`geometry`] follows sampled rays through partitions of a grid of any size.

use crate::ranks::{Sharing, Simulation};
use crate::results::{Table, number, progress, replace_section, say, three_digits};
use crate::scenes::multi_scale;
use geometry::{Partition, Shell};
use icoray::ranks::{Traffic, local_nodes_over, on_threads};
use icoray::{Error, ErrorKind, FrameReport, Ranks, Renderer, Result};
use icoray_reference::sphere::{self, Sphere};
use network::{Clock, Network, TimedMessages, read};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

mod geometry;
mod network;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the grid that the ranks render.
    #[arg(long, default_value_t = 6)]
    pub level: u32,
    /// Layers of that grid.
    #[arg(long, default_value_t = 4)]
    pub layers: usize,
    /// Width and height of its picture.
    #[arg(long, default_value_t = 256)]
    pub size: u32,
    /// Numbers of ranks, each of which is a thread.
    #[arg(long, value_delimiter = ',', default_values_t = [2, 16, 128, 1024, 4096])]
    pub ranks: Vec<usize>,
    /// The distribution of the grid over ranks.
    #[arg(long, value_delimiter = ',', value_enum, default_values_t = [Sharing::Patches])]
    pub sharing: Vec<Sharing>,
    /// The network.
    #[command(flatten)]
    pub network: Network,
    /// Bisections of the grid whose work is reckoned.
    #[arg(long, default_value_t = 11)]
    pub work_level: u32,
    /// Layers of that grid.
    #[arg(long, default_value_t = 99)]
    pub work_layers: usize,
    /// Numbers of nodes over which it is distributed.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 8, 64, 512])]
    pub nodes: Vec<usize>,
    /// Its partitions.
    #[arg(long, value_delimiter = ',', value_enum, default_values_t = [Partition::Patches, Partition::Curve, Partition::Bands])]
    pub partition: Vec<Partition>,
    /// Directory of exchange.csv and work.csv.
    #[arg(long, default_value = "out/scale")]
    pub out: PathBuf,
    /// A file in which tables take the place of those between its lines `<!-- icoray-study scale -->` or `<!--
    /// icoray-study scale work -->` and `<!-- end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}

const EXCHANGE: &str = "sharing,ranks,nodes,setup_s,setup_messages_per_rank,network_s,messages_per_rank,\
    most_messages,sent_bytes_per_rank,most_sent_bytes,most_link_bytes,most_node_memory_bytes,fragment_bytes_per_pixel,rank_0_received_bytes_per_pixel,fragments_per_pixel";

const WORK: &str = "partition,nodes,cells,layers,frusta_per_pixel,fragments_per_pixel,balance";

/// Side of the picture whose rays are followed for the work of nodes.
const SAMPLED: u32 = 128;

/// Renders, reckons and prints a line per distribution and number of ranks or nodes.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    if options.ranks.iter().chain(&options.nodes).chain([&options.network.node_ranks]).any(|count| *count == 0) {
        return Err(Error::new(ErrorKind::Argument, "0 ranks or nodes, expected at least 1"));
    }
    exchange(options, out)?;
    work(options, out)
}

struct RankExchange {
    sent: Traffic,
    /// Bytes to other nodes.
    link_bytes: u64,
    /// Time of the rank's clock at the end of the frame, and at that of the frame before.
    time_s: [f64; 2],
    /// What came before the frame: the agreement on parts and one frame.
    before: Traffic,
    report: FrameReport,
}

fn exchange(options: &Options, out: &mut dyn Write) -> Result<()> {
    let Network { latency_us, overhead_us, gb_per_s, node_ranks } = options.network;
    let sphere = Sphere::new(options.level, options.layers, [1.0, 1.15], sphere::multi_scale)?;
    say!(
        out,
        "exchange: {} cells x {} layers, {2} x {2} pixels; the second frame. Network: {latency_us} us from node to node,\n\
         {overhead_us} us per message at each end, {gb_per_s} GB/s per node of {node_ranks} ranks. Rays take no time.",
        sphere.mesh.cells(),
        options.layers,
        options.size
    )?;
    let mut csv = Table::create(options.out.join("exchange.csv"), EXCHANGE)?;
    say!(out, "{}", csv.heading())?;
    let scenes = [multi_scale::scene(options.size, multi_scale::TRANSFERS[0].1, "", "")?];
    let (bar, mut columns) = (progress(options.sharing.len() * options.ranks.len(), "exchange"), Vec::new());
    for &sharing in &options.sharing {
        for &ranks in &options.ranks {
            bar.set_message(format!("{ranks} ranks"));
            let simulation = Simulation::new(&sphere, sharing, ranks, &scenes, 2)?;
            let frame = simulated(&simulation, ranks, options.network)?;
            let figures = figures(&frame, f64::from(options.size).powi(2), node_ranks);
            let counts = [ranks, ranks.div_ceil(node_ranks)].map(|count| count.to_string());
            columns.push(column(counts.clone(), figures));
            let mut cells = vec![format!("{sharing:?}").to_lowercase()];
            cells.extend(counts.into_iter().chain(figures.map(number)));
            csv.print(&cells, &bar, out)?;
        }
    }
    replace_section(options.readme.as_deref(), "scale", &markdown(&columns))
}

/// The columns of [`EXCHANGE`] from `setup_s` on.
fn figures(frame: &[RankExchange], pixels: f64, node_ranks: usize) -> [f64; 12] {
    let (root, [end, begin]) = (&frame[0].report, frame[0].time_s);
    let of_ranks = |of: fn(&RankExchange) -> u64| {
        let most = frame.iter().map(of).max().unwrap_or(0) as f64;
        [frame.iter().map(of).sum::<u64>() as f64 / frame.len() as f64, most]
    };
    let most_of_nodes = |of: fn(&RankExchange) -> u64| {
        frame.chunks(node_ranks).map(|node| node.iter().map(of).sum::<u64>()).max().unwrap_or(0) as f64
    };
    // The frame before has about the same messages.
    let [setup_messages, _] = of_ranks(|rank| rank.before.messages.saturating_sub(rank.sent.messages));
    let [messages, most_messages] = of_ranks(|rank| rank.sent.messages);
    let [bytes, most_bytes] = of_ranks(|rank| rank.sent.bytes);
    [
        begin - (end - begin),
        setup_messages,
        end - begin,
        messages,
        most_messages,
        bytes,
        most_bytes,
        most_of_nodes(|rank| rank.link_bytes),
        most_of_nodes(|rank| rank.report.bytes_copied + rank.report.bytes_derived as u64),
        root.counts.fragment_bytes as f64 / pixels,
        root.ranks.bytes_received as f64 / pixels,
        root.counts.fragments as f64 / pixels,
    ]
}

/// A column of the book's table, with the names of its rows.
fn column([ranks, nodes]: [String; 2], of: [f64; 12]) -> Vec<(&'static str, String)> {
    let [setup_s, setup_messages, frame_s, messages, most_messages, bytes, most_bytes, link, node, fragments, tiles, _] =
        of;
    let some = |values: &[f64]| values.iter().map(|value| three_digits(*value)).collect::<Vec<_>>().join("; ");
    vec![
        ("ranks", ranks),
        ("nodes", nodes),
        ("exchanges of a frame, ms", some(&[1e3 * frame_s])),
        ("messages per rank: mean; most", some(&[messages, most_messages])),
        ("kB per rank: mean; most", some(&[1e-3 * bytes, 1e-3 * most_bytes])),
        ("most kB from a node to others", some(&[1e-3 * link])),
        ("most MB of memory on a node", some(&[1e-6 * node])),
        ("bytes per pixel: fragments; tiles", some(&[fragments, tiles])),
        ("`icoray_part_set`: ms; messages per rank", some(&[1e3 * setup_s, setup_messages])),
    ]
}

/// A table of columns, the first row of which is its head.
fn markdown(columns: &[Vec<(&'static str, String)>]) -> String {
    let row = |row: usize| {
        let cells = columns.iter().map(|column| column[row].1.as_str()).collect::<Vec<_>>();
        let head = if row == 0 { format!("|{}\n", "---|".repeat(columns.len() + 1)) } else { String::new() };
        format!("| {} | {} |\n{head}", columns[0][row].0, cells.join(" | "))
    };
    (0..columns.first().map_or(0, Vec::len)).map(row).collect()
}

/// Gives the process a hash table for the locks of so many threads.
///
/// Linux from 6.16 has one for each process, of a size for as many threads as there are processors, and each wake-up
/// searches all threads that wait in an entry of it. Earlier kernels refuse the call: their table is the system's.
#[cfg(target_os = "linux")]
fn reserve_locks(threads: usize) {
    const PR_FUTEX_HASH: libc::c_int = 78;
    const PR_FUTEX_HASH_SET_SLOTS: libc::c_ulong = 1;
    let (slots, flags): (libc::c_ulong, libc::c_ulong) = (threads.next_power_of_two() as libc::c_ulong, 0);
    // SAFETY: the call reads its arguments only, which are numbers.
    unsafe { libc::prctl(PR_FUTEX_HASH, PR_FUTEX_HASH_SET_SLOTS, slots, flags, 0 as libc::c_ulong) };
}

#[cfg(not(target_os = "linux"))]
fn reserve_locks(_: usize) {}

/// The last frame of all ranks.
fn simulated(simulation: &Simulation, ranks: usize, network: Network) -> Result<Vec<RankExchange>> {
    let node_of: Vec<usize> = (0..ranks).map(|rank| network.node_of(rank)).collect();
    let clocks: Vec<Clock> = (0..ranks).map(|_| Clock::default()).collect();
    let team = local_nodes_over(&node_of, |messages| {
        let clock = Arc::clone(&clocks[messages.rank()]);
        TimedMessages { messages, network, clock }
    });
    let renderer = Renderer::new(0)?;
    reserve_locks(ranks);
    let of_ranks = on_threads(team.into_iter().zip(&clocks).collect(), |(team, clock)| {
        let (mut before, mut began) = (Traffic::default(), read(clock));
        simulation.rank(&renderer, Ranks::new(team), |ranks, report| {
            let (sent, now) = (ranks.traffic(), read(clock));
            let last = std::mem::replace(&mut before, sent);
            let sent = Traffic { messages: sent.messages - last.messages, bytes: sent.bytes - last.bytes };
            let began = std::mem::replace(&mut began, now);
            let link_bytes = now.link_bytes - began.link_bytes;
            RankExchange { sent, link_bytes, time_s: [now.s, began.s], before: last, report }
        })
    });
    of_ranks.into_iter().filter_map(|frames| frames.map(|mut frames| frames.pop()).transpose()).collect()
}

fn work(options: &Options, out: &mut dyn Write) -> Result<()> {
    let cells = 10.0 * 4.0f64.powi(options.work_level as i32) + 2.0;
    let shell = Shell { cells, layers: options.work_layers, radius: [1.0, 1.15] };
    say!(
        out,
        "work: {cells:.0} cells x {} layers, {SAMPLED} x {SAMPLED} rays, none of which ends early",
        shell.layers
    )?;
    let mut csv = Table::create(options.out.join("work.csv"), WORK)?;
    say!(out, "{}", csv.heading())?;
    let scene = multi_scale::scene(SAMPLED, multi_scale::TRANSFERS[0].1, "", "")?;
    let mut columns = Vec::new();
    for &nodes in &options.nodes {
        let (mut balance, mut fragments) = (Vec::new(), Vec::new());
        for &partition in &options.partition {
            let work = geometry::work(&scene, shell, partition, nodes, SAMPLED);
            let mut cells = vec![format!("{partition:?}").to_lowercase(), nodes.to_string()];
            cells.extend([format!("{:.0}", shell.cells), shell.layers.to_string()]);
            cells.extend([work.frusta, work.fragments, work.balance()].map(number));
            say!(out, "{}", csv.row(&cells)?)?;
            balance.push(format!("{:.2}", work.balance()));
            fragments.push(three_digits(work.fragments));
        }
        let head = ("nodes", nodes.to_string());
        columns.push(vec![head, ("balance", balance.join("; ")), ("fragments per pixel", fragments.join("; "))]);
    }
    replace_section(options.readme.as_deref(), "scale work", &markdown(&columns))
}
