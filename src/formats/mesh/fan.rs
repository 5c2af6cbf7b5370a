//! Facets around a vertex, and the normals of their corners there.
//!
//! The facets are a tree by their normals, of a single leaf unless they are many: so a pole of a
//! hundred thousand triangles takes no time of their square. A facet's sum is over the same facets
//! in any tree, since bounds of rounded dot products are rounded bounds of them.

use glam::DVec3;
use std::ops::Range;

/// Largest number of facets in a leaf.
const LEAF: usize = 32;

/// A triangle, for fans around its corners.
#[derive(Clone, Copy, Default)]
pub(super) struct Facet {
    /// Its normal; 0 without an area.
    normal: DVec3,
    /// Factor that makes it a unit normal.
    unit: f64,
    /// The weight at each corner.
    weights: [f64; 3],
}

impl Facet {
    /// The facet of these vertices. Without an area, it weighs nothing.
    #[inline]
    pub(super) fn of([a, b, c]: [DVec3; 3]) -> Facet {
        let [ab, bc, ca] = [b - a, c - b, a - c];
        let normal = ca.cross(ab);
        let length = normal.length();
        if length == 0.0 {
            return Facet::default();
        }
        let (ab, bc, ca) = (
            ab.length_squared(),
            bc.length_squared(),
            ca.length_squared(),
        );
        Facet {
            normal,
            unit: 1.0 / length,
            weights: [1.0 / (ca * ab), 1.0 / (ab * bc), 1.0 / (bc * ca)],
        }
    }
}

/// A facet, seen from one of its corners.
#[derive(Clone, Copy, Debug)]
struct FanFacet {
    /// Unit normal of the facet.
    normal: DVec3,
    /// The normal with the weight of the corner.
    weighted: DVec3,
    /// Number of the facet in the fan.
    number: u32,
}

/// Facets beneath a node of the tree.
struct FanNode {
    /// Bounds of their normals.
    lo: DVec3,
    hi: DVec3,
    /// Sum of their weighted normals, in their order.
    sum: DVec3,
    facets: Range<usize>,
    /// The second of its two nodes, of which the first follows the node itself; 0 for a leaf.
    second: usize,
}

/// Facets around a vertex.
#[derive(Default)]
pub(super) struct Fan {
    facets: Vec<FanFacet>,
    /// Sum of their weighted normals, in their order.
    sum: DVec3,
    nodes: Vec<FanNode>,
}

impl Fan {
    pub(super) fn clear(&mut self) {
        self.facets.clear();
        self.sum = DVec3::ZERO;
        self.nodes.clear();
    }

    /// Adds the next facet, of which this corner is at the vertex.
    #[inline]
    pub(super) fn push(&mut self, facet: &Facet, corner: usize) {
        let weighted = facet.normal * facet.weights[corner];
        self.sum += weighted;
        self.facets.push(FanFacet {
            normal: facet.normal * facet.unit,
            weighted,
            number: self.facets.len() as u32,
        });
    }

    /// The mean of all facets, if its product with each is at least `half`.
    #[inline]
    pub(super) fn whole(&self, half: f64) -> Option<DVec3> {
        let all = self.sum.normalize();
        let is_whole = self
            .facets
            .iter()
            .all(|facet| all.dot(facet.normal) >= half);
        is_whole.then_some(all)
    }

    /// Returns true if the product of a facet's normal with this one is less than `flat`.
    pub(super) fn is_bent(&self, normal: DVec3, flat: f64) -> bool {
        self.facets
            .iter()
            .any(|facet| normal.dot(facet.normal) < flat)
    }

    /// Calls `take` with the number of each facet, and the normal of its corner, after its product
    /// with that of the facet: a mean of the facets whose product with its own is at least `least`.
    pub(super) fn corner_normals(&mut self, least: f64, mut take: impl FnMut(u32, f64, DVec3)) {
        self.grow(0..self.facets.len());
        let all = self.nodes[0].sum.normalize();
        for facet in &self.facets {
            let own = facet.normal;
            let is_whole = self.nodes[0].dots(own)[0] >= least;
            let normal = if is_whole { all } else { self.sum(0, own, least).normalize() };
            // Normals cancel out, or turn away from the facet, if nearly all angles are smooth.
            let normal = if normal.dot(own) > 0.0 { normal } else { own };
            take(facet.number, normal.dot(own), normal);
        }
    }

    /// Adds the node of these facets, and those beneath it.
    fn grow(&mut self, range: Range<usize>) {
        let facets = &mut self.facets[range.clone()];
        let (mut lo, mut hi, mut sum) = (DVec3::INFINITY, DVec3::NEG_INFINITY, DVec3::ZERO);
        for facet in facets.iter() {
            (lo, hi) = (lo.min(facet.normal), hi.max(facet.normal));
            sum += facet.weighted;
        }
        let node = self.nodes.len();
        self.nodes.push(FanNode {
            lo,
            hi,
            sum,
            facets: range.clone(),
            second: 0,
        });
        if range.len() > LEAF {
            let axis = (hi - lo).max_position();
            // Equal normals are in the order of their numbers, so there is one order for each fan.
            facets.sort_unstable_by(|a, b| {
                let along = a.normal[axis].total_cmp(&b.normal[axis]);
                along.then(a.number.cmp(&b.number))
            });
            let middle = range.start + range.len() / 2;
            self.grow(range.start..middle);
            self.nodes[node].second = self.nodes.len();
            self.grow(middle..range.end);
        }
    }

    /// Sum of the weighted normals beneath a node that are within the angle of `own`.
    fn sum(&self, node: usize, own: DVec3, least: f64) -> DVec3 {
        let FanNode { facets, second, .. } = &self.nodes[node];
        let [lowest, highest] = self.nodes[node].dots(own);
        if lowest >= least {
            self.nodes[node].sum
        } else if highest < least {
            DVec3::ZERO
        } else if *second > 0 {
            self.sum(node + 1, own, least) + self.sum(*second, own, least)
        } else {
            let facets = self.facets[facets.clone()].iter();
            let near = facets.filter(|facet| own.dot(facet.normal) >= least);
            near.fold(DVec3::ZERO, |sum, facet| sum + facet.weighted)
        }
    }
}

impl FanNode {
    /// Bounds of the dot products of normals beneath it with another one.
    #[inline]
    fn dots(&self, own: DVec3) -> [f64; 2] {
        let (a, b) = (own * self.lo, own * self.hi);
        [a.min(b).element_sum(), a.max(b).element_sum()]
    }
}
