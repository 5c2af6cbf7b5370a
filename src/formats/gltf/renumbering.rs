//! Numbers of the vertices of a mesh: those that its triangles use, in the order of their first
//! use.

use phalanx_scene::huge_pages::room;
use std::collections::HashMap;

/// Triangles of a primitive with the vertices' new numbers.
pub(super) struct Renumbered {
    /// Row of each vertex in the accessors.
    pub(super) rows: Vec<u32>,
    pub(super) corners: Vec<[u32; 3]>,
}

/// New numbers of vertices by their rows: a table if most are used, a map if few are.
enum NumberTable {
    Table(Vec<u32>),
    Map(HashMap<u32, u32>),
}

/// Stands for a vertex without a number so far.
const UNUSED: u32 = u32::MAX;
/// Stands for a vertex that gets no number.
const LOST: u32 = u32::MAX - 1;

impl NumberTable {
    #[inline]
    fn slot(&mut self, row: u32) -> &mut u32 {
        match self {
            NumberTable::Table(table) => &mut table[row as usize],
            NumberTable::Map(map) => map.entry(row).or_insert(UNUSED),
        }
    }
}

impl Renumbered {
    /// Numbers the corners of triangles of `vertices` vertices. Triangles with one of the `lost`
    /// rows are left out, but their other vertices are not.
    pub(super) fn of(
        triangles: impl ExactSizeIterator<Item = [u32; 3]>,
        vertices: usize,
        lost: &[u32],
    ) -> Renumbered {
        // The table's size is at most a few times what is read anyway.
        let mut numbers = if vertices <= 12 * triangles.len() {
            NumberTable::Table(vec![UNUSED; vertices])
        } else {
            NumberTable::Map(HashMap::new())
        };
        for &row in lost {
            *numbers.slot(row) = LOST;
        }
        let mut rows = Vec::new();
        let mut corners = room(triangles.len());
        for triangle in triangles {
            let triangle = triangle.map(|row| {
                let number = numbers.slot(row);
                if *number == UNUSED {
                    *number = rows.len() as u32;
                    rows.push(row);
                }
                *number
            });
            if !triangle.contains(&LOST) {
                corners.push(triangle);
            }
        }
        Renumbered { rows, corners }
    }
}
