//! Frames that ranks draw together in the background; calls of the model transfer their messages.

use super::*;
use crate::ranks::{Team, on_local_nodes};
use crate::spread::Rows;
use std::sync::Barrier;

/// One rank of a model.
struct Rank<'s> {
    fixture: &'s Fixture,
    ranks: Ranks,
    background: Background,
    /// Of every n-th column of the field on n ranks; `None` if each has all of it.
    decomposition: Option<Arc<Decomposition>>,
    cells: Vec<usize>,
    /// The model's own communication.
    model: &'s Barrier,
}

impl<'s> Rank<'s> {
    fn new(fixture: &'s Fixture, team: Team, is_spread: bool, model: &'s Barrier) -> Self {
        let mut ranks = Ranks::new(team);
        let (rank, size) = (ranks.rank(), ranks.size());
        let renderer = Arc::new(Renderer::new(1).unwrap());
        let background = Background::over(&mut ranks, renderer, fixture.writer.clone()).unwrap();
        let is_mine = |cell: &usize| !is_spread || cell % size == rank;
        let cells: Vec<usize> = (0..fixture.grid.cells()).filter(is_mine).collect();
        let decomposition = is_spread.then(|| {
            let rows = Rows::own(cells.clone());
            Arc::new(Decomposition::new(&mut ranks, &fixture.grid, &rows.cells()).unwrap())
        });
        Rank { fixture, ranks, background, decomposition, cells, model }
    }

    fn setup(&self, step: i64) -> FrameSetup {
        FrameSetup { decomposition: self.decomposition.clone(), ..self.fixture.setup(step) }
    }

    /// Hands a step over and spoils the model's memory.
    fn submit(&mut self, setup: FrameSetup) -> Result<Accepted> {
        let mut values = values(setup.stamp.step, &self.cells);
        let field = Field::level_fastest(&values, 3, Location::Center).unwrap();
        let frame = FrameInputs { setup, fields: Fields::new([("q", field)]) };
        let accepted = submit(&mut self.background, &mut self.ranks, frame);
        values.fill(f64::NAN);
        accepted
    }

    /// A step of the model: ranks meet in it, and each moves messages on at another time.
    fn compute(&mut self) {
        self.model.wait();
        std::thread::sleep(std::time::Duration::from_micros(300 * self.ranks.rank() as u64));
        self.background.pump();
        self.model.wait();
    }

    fn outcomes(&mut self) -> Vec<Drawn> {
        self.background.wait();
        self.background.take_outcomes().kept
    }
}

fn values(step: i64, cells: &[usize]) -> Vec<f64> {
    let layers = |cell: &usize| (3 * cell..3 * cell + 3).map(|i| (i as f64 * 0.01 * step as f64).sin());
    cells.iter().flat_map(layers).collect()
}

/// The results of `model` for each rank; ranks with the same number are on one node.
fn on_each<R: Send>(
    fixture: &Fixture,
    nodes: &[usize],
    is_spread: bool,
    model: impl Fn(&mut Rank) -> R + Sync,
) -> Vec<R> {
    let barrier = Barrier::new(nodes.len());
    on_local_nodes(nodes, |team| model(&mut Rank::new(fixture, team, is_spread, &barrier)))
}

#[test]
fn pictures_of_ranks_are_those_of_one_process() {
    for (nodes, is_spread) in
        [(&[0][..], false), (&[0, 0], false), (&[0, 0, 0, 0], false), (&[0, 0], true), (&[0, 0, 1, 1], true)]
    {
        let fixture = Fixture::new();
        let all: Vec<usize> = (0..fixture.grid.cells()).collect();
        let reports = on_each(&fixture, nodes, is_spread, |rank| {
            for step in 1..=4 {
                let accepted = rank.submit(rank.setup(step)).unwrap();
                assert!(accepted.bytes_copied >= 24 * rank.cells.len() as u64, "{accepted:?}");
                assert!(is_spread || accepted.bytes_copied == 24 * all.len() as u64);
                assert!(rank.background.is_under_way());
                // The second frame comes to an end by the model's steps, others in the next call.
                (0..if step == 2 { 100 } else { 2 }).for_each(|_| rank.compute());
            }
            let drawn = rank.outcomes();
            assert!(!rank.background.is_under_way());
            drawn.into_iter().map(|drawn| drawn.result.unwrap()).collect::<Vec<_>>()
        });
        fixture.writer.wait();
        assert_eq!(fixture.writer.take_outcomes().errors().count(), 0);
        for step in 1..=4 {
            let values = values(step, &all);
            let field = Field::level_fastest(&values, 3, Location::Center).unwrap();
            let expected = fixture.draw(&field);
            let drawn = read(&fixture.folder.path().join(format!("{step}.exr")));
            assert!(drawn == expected.pixels, "step {step} on {nodes:?}, spread: {is_spread}");
            for reports in &reports {
                let report = &reports[step as usize - 1];
                assert_eq!((report.ranks.count, report.threads), (nodes.len(), 1));
                assert_eq!(report.counts.rays, expected.report.counts.rays);
            }
        }
    }
}

/// The background of a rank that fails at some steps: before a frame, within one, and in a phase of one.
fn failing(team: &mut Team, fixture: &Fixture) -> Background {
    let (pumped, pump) = team.pumped().unwrap();
    let (renderer, writer) = (Arc::new(Renderer::new(1).unwrap()), fixture.writer.clone());
    let (with, to) = (renderer.clone(), writer.clone());
    let fail = move |ranks: &mut Ranks, setup: FrameSetup, copies: &Copies, cost| {
        match (setup.stamp.step, ranks.rank()) {
            (1, 2) => panic!("before the frame"),
            (2, 1) => panic!("within the frame of {}", ranks.share(&[1])?.len()),
            (2, _) => drop(ranks.share(&[0])?),
            (3, rank) => {
                ranks.collective_work(|| {
                    assert!(rank != 1, "a phase");
                    Ok(())
                })?;
            }
            _ => {}
        }
        draw(&with, ranks, &to, setup, copies, cost)
    };
    Background::with(renderer, writer, Ranks::new(pumped), Some(pump), fail).unwrap()
}

/// A panic in a phase is the failure of all; one outside of any ends the frame on the others too. Frames behind it are
/// drawn.
#[test]
fn a_failure_on_one_rank_ends_the_frame_on_all() {
    let (fixture, model) = (&Fixture::new(), &Barrier::new(3));
    let said = on_local_nodes(&[0; 3], |mut team| {
        let background = failing(&mut team, fixture);
        let ranks = Ranks::new(team);
        let cells = (0..fixture.grid.cells()).collect();
        let mut rank = Rank { fixture, ranks, background, decomposition: None, cells, model };
        for step in 1..=4 {
            rank.submit(rank.setup(step)).unwrap();
            rank.compute();
        }
        let outcome = |drawn: Drawn| match drawn.result {
            Ok(_) => "drawn".to_string(),
            Err(error) => format!("{error}{}", if drawn.is_of_all { "" } else { ", alone" }),
        };
        rank.outcomes().into_iter().map(outcome).collect::<Vec<_>>()
    });
    for (rank, said) in said.into_iter().enumerate() {
        let message = |by: usize, text: &str| match by == rank {
            true => format!("internal error: {text}, alone"),
            false => format!("internal error: rank {by}: {text}"),
        };
        let of_all = "internal error: rank 1: a phase".to_string();
        let expected = [message(2, "before the frame"), message(1, "within the frame of 3"), of_all, "drawn".into()];
        assert_eq!(said, expected, "rank {rank}");
    }
    fixture.writer.wait();
    assert!(fixture.folder.path().join("4.exr").is_file() && !fixture.folder.path().join("2.exr").exists());
}

/// An error of a frame on one rank only is refused on all, and so is a name that rank 0 may not write.
#[test]
fn a_frame_that_is_wrong_on_one_rank_is_refused_on_all() {
    let fixture = Fixture::new();
    let said = on_each(&fixture, &[0, 0], false, |rank| {
        rank.submit(rank.setup(1)).unwrap();
        let taken = rank.submit(rank.setup(1)).unwrap_err();
        let few = Arc::new(Layers::from_heights(&[0.0, 1e4], 6.371e6).unwrap());
        let mut odd = rank.setup(2);
        if rank.ranks.rank() == 1 {
            odd.layers = few;
        }
        let odd = rank.submit(odd).unwrap_err();
        rank.submit(rank.setup(3)).unwrap();
        let steps: Vec<_> = rank.outcomes().iter().map(|drawn| drawn.stamp.step).collect();
        assert_eq!(steps, [1, 3]);
        assert_eq!(taken.kind(), ErrorKind::Exists);
        [taken.to_string(), odd.to_string()]
    });
    assert_eq!(said[0], said[1]);
    assert!(said[0][1].contains("rank 1: "), "{said:?}");
}

/// Without a call that moves messages on a frame of several ranks is not drawn, and no rank waits for it.
#[test]
fn dropping_it_ends_a_frame_of_several_ranks() {
    let fixture = Fixture::new();
    on_each(&fixture, &[0, 0], false, |rank| rank.submit(rank.setup(1)).unwrap());
    fixture.writer.wait();
    assert!(!fixture.folder.path().join("1.exr").exists());
}
