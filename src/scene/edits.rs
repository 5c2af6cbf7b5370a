//! Stamps of a scene's parts, by which a tree knows what it has to follow.

use crate::geometries::GeomId;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Number that no other scene or edit has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp(u64);

impl Stamp {
    /// Stamp of parts that have never been edited.
    const NONE: Stamp = Stamp(0);

    fn new() -> Stamp {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Stamp(NEXT.fetch_add(1, Relaxed))
    }
}

/// Stamps of a scene's parts. Two scenes with equal stamps of a part have the same part, unless
/// columns were changed by hand.
#[derive(Clone, PartialEq, Eq)]
pub struct Edits {
    /// The scene itself, and the number of primitives that no call has added as a geometry.
    scene: (Stamp, usize),
    /// Number of primitives of geometries and prototypes.
    in_places: usize,
    /// Number of the others when one of those was added last.
    by_hand: usize,
    pub(crate) geometries: StampsByPart,
    pub(crate) prototypes: StampsByPart,
}

/// Stamps of geometries, or of prototypes, by number. Those without a row have never been edited.
#[derive(Clone, Default, PartialEq, Eq)]
pub(crate) struct StampsByPart(Vec<PartStamps>);

/// Stamps of a geometry or a prototype.
#[derive(Clone, Copy, PartialEq, Eq)]
struct PartStamps {
    /// Which primitives it has, and whether they are visible.
    contents: Stamp,
    /// Where its vertices are, or its map.
    position: Stamp,
}

impl PartStamps {
    const NONE: PartStamps = PartStamps {
        contents: Stamp::NONE,
        position: Stamp::NONE,
    };
}

/// Stamps say nothing to a reader, and differ from run to run.
impl fmt::Debug for Edits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Edits")
    }
}

impl Default for Edits {
    /// The edits of a new scene, which no other equals.
    fn default() -> Self {
        Edits {
            scene: (Stamp::new(), 0),
            in_places: 0,
            by_hand: 0,
            geometries: StampsByPart::default(),
            prototypes: StampsByPart::default(),
        }
    }
}

/// Differences between the scene that a tree was made for and another one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneChanges {
    /// True for another scene, and if primitives that belong to no geometry were added; nothing
    /// else is known then.
    pub everything: bool,
    /// Geometries that differ, ascending.
    pub geometries: Vec<PartChange>,
    /// Prototypes that differ, ascending.
    pub prototypes: Vec<PartChange>,
}

/// Difference between a geometry, or a prototype, and an earlier one of its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartChange {
    /// The number.
    pub id: GeomId,
    /// True if it was added, removed, shown or hidden.
    pub contents: bool,
    /// True if its vertices, or its map, are others.
    pub moved: bool,
}

impl Edits {
    /// Notes that nothing is as it was.
    pub(crate) fn mark_everything(&mut self) {
        self.scene.0 = Stamp::new();
    }

    /// Adds primitives to those of geometries and prototypes, behind `before` ones. Primitives that
    /// were added by hand before them have numbers that they have in no other scene.
    pub(crate) fn add_to_places(&mut self, before: usize, prims: usize) {
        let by_hand = before.saturating_sub(self.in_places);
        if by_hand != self.by_hand {
            self.mark_everything();
            self.by_hand = by_hand;
        }
        self.in_places += prims;
    }

    /// The stamps with the number of all primitives: those that were added by hand have no stamp.
    pub(crate) fn with_prims(&self, prims: usize) -> Edits {
        let mut edits = self.clone();
        edits.scene.1 = prims.saturating_sub(self.in_places);
        edits
    }

    /// Compares the stamps of a scene with earlier ones.
    pub(crate) fn changes_since(&self, before: &Edits) -> SceneChanges {
        SceneChanges {
            everything: self.scene != before.scene,
            geometries: self.geometries.changes_since(&before.geometries),
            prototypes: self.prototypes.changes_since(&before.prototypes),
        }
    }
}

impl StampsByPart {
    /// Notes that a part has got other primitives, in a place of its own.
    pub(crate) fn mark_added(&mut self, id: u32) {
        self.mark_contents(id);
        self.mark_moved(id);
    }

    /// Notes that a part was removed, shown or hidden.
    pub(crate) fn mark_contents(&mut self, id: u32) {
        self.stamps(id).contents = Stamp::new();
    }

    pub(crate) fn mark_moved(&mut self, id: u32) {
        self.stamps(id).position = Stamp::new();
    }

    fn stamps(&mut self, id: u32) -> &mut PartStamps {
        let row = id as usize;
        if self.0.len() <= row {
            self.0.resize(row + 1, PartStamps::NONE);
        }
        &mut self.0[row]
    }

    fn changes_since(&self, before: &StampsByPart) -> Vec<PartChange> {
        let change = |k: usize| {
            let stamps = |parts: &StampsByPart| parts.0.get(k).copied();
            let [now, before] = [self, before].map(|all| stamps(all).unwrap_or(PartStamps::NONE));
            (now != before).then_some(PartChange {
                id: k as GeomId,
                contents: now.contents != before.contents,
                moved: now.position != before.position,
            })
        };
        let count = self.0.len().max(before.0.len());
        (0..count).filter_map(change).collect()
    }
}
