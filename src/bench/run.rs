//! One scene, measured: the order of the stages.

use super::frames::Frames;
use super::lineup::{Member, Rival, kernels, lineup};
use super::plan::{Heading, Listener, Plan};
use super::race::{Entry, Task, race};
use super::subject::{self, Question, Trees, timed};
use super::work;
use super::wrong::Wrong;
use crate::report::{CounterRow, Row, SceneRecord};
use bumpalo::Bump;
use phalanx_scene::Scene;

/// What came of a scene.
pub struct Measured {
    /// The scene.
    pub scene: SceneRecord,
    /// Its rates; none where the plan only counts.
    pub rows: Vec<Row>,
    /// Its counted work.
    pub counters: Vec<CounterRow>,
    /// What a reader should know, such as a peer that could not take part.
    pub notes: Vec<String>,
}

/// Measures a validated scene: trees, rays, the right answers, everybody's answers, counts, and only then times.
///
/// # Errors
/// [`Wrong`] if one of our kernels, or the oracle, does not give the right answer: then there are no rates.
pub fn measure(
    scene: &Scene,
    heading: &Heading,
    plan: &Plan,
    listener: &mut dyn Listener,
) -> Result<Measured, Wrong> {
    listener.doing("building");
    let mut trees = Trees::build(scene, plan);
    let (rivals, notes) = rivals(scene, heading, plan, &mut trees);
    listener.doing("checking");
    let arena = Bump::new();
    let questions = subject::questions(&arena, scene, &trees, plan, heading)?;
    for question in &questions {
        subject::check(scene, &trees, question, plan, heading)?;
    }
    let frames = Frames::of(scene, &trees, plan);
    let frame_hits = frames.check(heading)?;
    let counters = counters(&trees, &questions, plan, heading);
    let scene_record = subject::scene_record(scene, heading, &trees, &questions, plan.size);
    let mut rows = Vec::new();
    if plan.timed {
        let lineups: Vec<Vec<Member>> = questions
            .iter()
            .map(|question| lineup(scene, &trees, &rivals, question, plan))
            .collect();
        let mut entries = entries(&questions, &lineups, plan, heading);
        entries.extend(frames.entries(heading, frame_hits));
        listener.doing("measuring");
        rows = race(entries, plan, listener);
    }
    Ok(Measured {
        scene: scene_record,
        rows,
        counters,
        notes,
    })
}

/// The peers that can trace the scene; the others are named.
fn rivals(
    scene: &Scene,
    heading: &Heading,
    plan: &Plan,
    trees: &mut Trees,
) -> (Vec<Rival>, Vec<String>) {
    let (mut rivals, mut notes) = (Vec::new(), Vec::new());
    let threads = plan.most_threads();
    for peer in plan.peers.iter().filter(|_| plan.timed) {
        let (built, seconds) = timed(|| peer.build(scene, threads));
        match built {
            Ok(rival) => {
                trees.seconds.insert(peer.name().to_owned(), seconds);
                rivals.push((peer.name(), rival));
            }
            Err(unsupported) => notes.push(format!("{}: {unsupported}", heading.name)),
        }
    }
    (rivals, notes)
}

fn counters(
    trees: &Trees,
    questions: &[Question],
    plan: &Plan,
    heading: &Heading,
) -> Vec<CounterRow> {
    let rows = questions.iter().flat_map(|question| {
        let kernels = kernels(plan).into_iter();
        kernels.map(|kernel| work::count(&heading.name, &trees.bvh, kernel, question))
    });
    rows.collect()
}

/// Side by side what is compared: for each kind and number of threads, all engines.
fn entries<'a>(
    questions: &'a [Question],
    lineups: &'a [Vec<Member>],
    plan: &Plan,
    heading: &Heading,
) -> Vec<Entry<'a>> {
    let mut entries = Vec::new();
    for (question, lineup) in questions.iter().zip(lineups) {
        for &threads in &plan.threads {
            entries.extend(lineup.iter().map(|member| {
                let task = Task::Rays {
                    contender: &*member.contender,
                    question: question.kind().question(),
                    chunks: member.chunks(question),
                    rays: question.rays(),
                };
                Entry::new(member.row(heading, question, threads), task)
            }));
        }
    }
    entries
}
