//! Boxes of clusters as columns, one cluster per lane.

use crate::bvh::prim_ref::PrimRef;
use crate::simd::NATIVE;

/// Padding clusters before the first and after the last. Their boxes are infinite, so they are
/// never preferred.
pub(super) const PADDING: usize = NATIVE + 32;

/// Set in references to merges; clear in those to objects.
const IS_MERGE: u32 = 1 << 31;

/// The content of a cluster: an object, or a merge of two clusters.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct ClusterRef(u32);

impl ClusterRef {
    #[inline(always)]
    pub(super) fn object(index: usize) -> ClusterRef {
        ClusterRef(index as u32)
    }

    #[inline(always)]
    pub(super) fn merge(index: usize) -> ClusterRef {
        ClusterRef(index as u32 | IS_MERGE)
    }

    /// The index of a merge, or else that of an object as an error.
    #[inline(always)]
    pub(super) fn index(self) -> Result<usize, usize> {
        let index = (self.0 & !IS_MERGE) as usize;
        if self.0 & IS_MERGE == 0 { Err(index) } else { Ok(index) }
    }
}

/// Clusters in the order of the curve.
#[derive(Default)]
pub(super) struct Clusters {
    /// Lower corners by axis, then upper corners; each column has [`PADDING`] extra rows at both
    /// ends.
    columns: [Vec<f32>; 6],
    refs: Vec<ClusterRef>,
}

impl Clusters {
    /// One cluster per object.
    pub(super) fn set(&mut self, objects: &[PrimRef]) {
        for (k, column) in self.columns.iter_mut().enumerate() {
            column.clear();
            column.resize(objects.len() + 2 * PADDING, infinite(k));
        }
        let [x0, y0, z0, x1, y1, z1] = self.columns.each_mut().map(|c| &mut c[PADDING..]);
        for (k, object) in objects.iter().enumerate() {
            [x0[k], y0[k], z0[k], x1[k], y1[k], z1[k]] = object.planes();
        }
        self.refs.clear();
        self.refs.extend((0..objects.len()).map(ClusterRef::object));
    }

    pub(super) fn len(&self) -> usize {
        self.refs.len()
    }

    /// The content of the first cluster; once all are merged, that of the whole chunk.
    pub(super) fn root(&self) -> ClusterRef {
        self.refs[0]
    }

    /// The columns from a cluster on; there are [`PADDING`] rows after the last.
    #[inline(always)]
    pub(super) fn columns_from(&self, first: usize) -> [&[f32]; 6] {
        let from = first + PADDING;
        let [a, b, c, d, e, f] = &self.columns;
        [
            &a[from..],
            &b[from..],
            &c[from..],
            &d[from..],
            &e[from..],
            &f[from..],
        ]
    }

    /// The contents of two clusters.
    #[inline(always)]
    pub(super) fn parts(&self, pair: [u32; 2]) -> [ClusterRef; 2] {
        [self.refs[pair[0] as usize], self.refs[pair[1] as usize]]
    }

    #[inline(always)]
    pub(super) fn set_content(&mut self, k: usize, content: ClusterRef) {
        self.refs[k] = content;
    }

    /// The box of a cluster.
    #[inline(always)]
    pub(super) fn planes(&self, k: usize) -> [f32; 6] {
        let [a, b, c, d, e, f] = &self.columns;
        let row = k + PADDING;
        [a[row], b[row], c[row], d[row], e[row], f[row]]
    }

    /// Stores the union of the k-th pair's boxes at position k. Pairs refer to old positions, which
    /// ascend and are not before the new one.
    pub(super) fn unite(&mut self, pairs: &[[u32; 2]]) {
        let [x0, y0, z0, x1, y1, z1] = self.columns.each_mut().map(|c| &mut c[PADDING..]);
        for column in [x0, y0, z0] {
            for (k, [a, b]) in pairs.iter().enumerate() {
                let (a, b) = (column[*a as usize], column[*b as usize]);
                column[k] = if a < b { a } else { b };
            }
        }
        for column in [x1, y1, z1] {
            for (k, [a, b]) in pairs.iter().enumerate() {
                let (a, b) = (column[*a as usize], column[*b as usize]);
                column[k] = if a > b { a } else { b };
            }
        }
    }

    /// Keeps the first `len` clusters.
    pub(super) fn truncate(&mut self, len: usize) {
        self.refs.truncate(len);
        for (k, column) in self.columns.iter_mut().enumerate() {
            column.truncate(len + PADDING);
            column.resize(len + 2 * PADDING, infinite(k));
        }
    }
}

/// The plane of a box that contains everything, in one of the columns.
fn infinite(column: usize) -> f32 {
    if column < 3 { f32::NEG_INFINITY } else { f32::INFINITY }
}
