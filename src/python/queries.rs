//! Rays through a scene: the closest hit, any hit, all hits.

use crate::arrays::shaped;
use crate::errors::value_error;
use crate::hits::{HitVectors, PyAllHits, PyHits, RaySource};
use crate::interrupt::{PIECE, SMALL_PIECE, pieces};
use crate::rays::{FilterArguments, RayFilters, Rays};
use crate::scene::PyScene;
use numpy::PyArrayDyn;
use phalanx::{BatchError, BatchFilter, Bvh, HitColumns, HitLists, RayRows, Scene};
use pyo3::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// A query: rays, and the scene at the time of the call.
struct RayQuery<'py> {
    rays: Rays<'py>,
    filters: Option<RayFilters<'py>>,
    scene: Arc<Scene>,
    bvh: Arc<Bvh>,
    threads: usize,
}

impl<'py> RayQuery<'py> {
    fn of(
        scene: &Bound<'py, PyScene>,
        [origins, directions, tmax]: [Option<&Bound<'py, PyAny>>; 3],
        filters: FilterArguments<'_, 'py>,
        threads: Option<i64>,
    ) -> PyResult<RayQuery<'py>> {
        let threads = crate::scene::threads(threads)?;
        let now = scene.get().now(scene.py());
        let origins = origins.ok_or_else(|| value_error("no rays"))?;
        let rays = Rays::of(origins, directions, tmax, &now.coordinates())?;
        let bvh = now.tree(scene.py())?;
        if !bvh.has_wide() {
            scene.py().detach(|| bvh.build_wide(threads));
        }
        Ok(RayQuery {
            filters: RayFilters::of(filters, &rays.shape)?,
            rays,
            bvh,
            scene: now.scene,
            threads,
        })
    }
}

impl RayQuery<'_> {
    /// Casts the rays in pieces of this size, so that Ctrl-C is heard: `cast` is called with the
    /// rows of a piece, their filters and their range.
    fn in_pieces(
        &self,
        py: Python<'_>,
        size: usize,
        mut cast: impl FnMut(&RayRows, Option<BatchFilter>, Range<usize>) -> Result<(), BatchError>
        + Send,
    ) -> PyResult<()> {
        for (from, to) in pieces(self.rays.len(), size) {
            let rows = self.rays.rows(from, to)?;
            let filters = self.filters.as_ref();
            let filter = filters.map(|filters| filters.rows(from, to)).transpose()?;
            py.detach(|| cast(&rows, filter, from..to))
                .map_err(value_error)?;
            py.check_signals()?;
        }
        Ok(())
    }
}

#[pymethods]
impl PyScene {
    /// The closest hit of each ray, as Hits.
    ///
    /// origins, directions : (..., 3)
    ///     Either may be a single row for all, or any other shape that numpy
    ///     broadcasts. Alternatively origins alone, as (..., 6): each origin
    ///     followed by its direction. C-contiguous float32 arrays are used as
    ///     they are, others are converted. Directions may have lengths from
    ///     1e-12 to 1e12: distances are in units of it.
    /// tmax : a number, or an array with one for each ray
    ///     Hits count if 0 < t < tmax. None is infinity.
    /// threads : int; 0 or None for one per CPU
    /// tnear : a number, or an array with one for each ray
    ///     Hits count if tnear < t, too: the ray passes through nearer ones,
    ///     also into a sphere, whose far side it then hits.
    /// mask : an integer, or an array of integers, with one for each ray
    ///     Only geometries whose mask shares a bit count: see set_mask().
    /// ignore : an integer, or an array of integers, with one for each ray
    ///     prim_id that does not count, such as that of the triangle that the
    ///     ray leaves; -1 for none, so that prim_id of other hits will do.
    ///
    /// The last three are slower for coherent rays, such as a camera's. Among
    /// hits at one distance, the smallest prim_id wins. No ray slips through
    /// an edge or a vertex that triangles share. Rays with a component that is
    /// not finite, a zero direction, or a tmax that is not positive hit
    /// nothing. Queries are fastest if adjacent rays have similar directions.
    ///
    /// Raises ValueError for wrong shapes and for threads below 0, TypeError
    /// for non-numeric arrays, KeyboardInterrupt within about a second of
    /// Ctrl-C.
    #[pyo3(signature = (
        origins, directions=None, tmax=None, threads=None, *, tnear=None, mask=None, ignore=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn intersect(
        slf: &Bound<'_, PyScene>,
        origins: &Bound<'_, PyAny>,
        directions: Option<&Bound<'_, PyAny>>,
        tmax: Option<&Bound<'_, PyAny>>,
        threads: Option<i64>,
        tnear: Option<&Bound<'_, PyAny>>,
        mask: Option<&Bound<'_, PyAny>>,
        ignore: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyHits> {
        let py = slf.py();
        let (rays, filters) = ([Some(origins), directions, tmax], [tnear, mask, ignore]);
        let query = RayQuery::of(slf, rays, filters, threads)?;
        let mut hits = HitVectors::new(query.rays.len());
        let (bvh, threads) = (&query.bvh, query.threads);
        query.in_pieces(py, PIECE, |rows, filter, range| {
            let mut columns = HitColumns {
                t: &mut hits.t[range.clone()],
                u: &mut hits.u[range.clone()],
                v: &mut hits.v[range.clone()],
                prim_id: &mut hits.prim_id[range.clone()],
                geom_id: &mut hits.geom_id[range],
            };
            match filter {
                None => bvh.intersect_batch(rows, &mut columns, threads),
                Some(filter) => bvh.intersect_batch_filtered(rows, &filter, &mut columns, threads),
            }
        })?;
        let from = RaySource::of(query.scene, origins, directions);
        PyHits::new(py, hits, query.rays.shape, from)
    }

    /// True for each ray that hits anything before its tmax: bool, of the
    /// rays' shape without the last dimension. Faster than intersect().
    ///
    /// Arguments and errors as for intersect().
    #[pyo3(signature = (
        origins, directions=None, tmax=None, threads=None, *, tnear=None, mask=None, ignore=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn occluded<'py>(
        slf: &Bound<'py, PyScene>,
        origins: &Bound<'py, PyAny>,
        directions: Option<&Bound<'py, PyAny>>,
        tmax: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
        tnear: Option<&Bound<'py, PyAny>>,
        mask: Option<&Bound<'py, PyAny>>,
        ignore: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let py = slf.py();
        let (rays, filters) = ([Some(origins), directions, tmax], [tnear, mask, ignore]);
        let query = RayQuery::of(slf, rays, filters, threads)?;
        let mut blocked = vec![false; query.rays.len()];
        let (bvh, threads) = (&query.bvh, query.threads);
        query.in_pieces(py, PIECE, |rows, filter, range| {
            let blocked = &mut blocked[range];
            match filter {
                None => bvh.occluded_batch(rows, blocked, threads),
                Some(filter) => bvh.occluded_batch_filtered(rows, &filter, blocked, threads),
            }
        })?;
        shaped(py, blocked, &query.rays.shape)
    }

    /// Number of primitives that each ray hits before its tmax: uint32, of the
    /// rays' shape without the last dimension.
    ///
    /// Arguments and errors as for intersect().
    #[pyo3(signature = (
        origins, directions=None, tmax=None, threads=None, *, tnear=None, mask=None, ignore=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn count<'py>(
        slf: &Bound<'py, PyScene>,
        origins: &Bound<'py, PyAny>,
        directions: Option<&Bound<'py, PyAny>>,
        tmax: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
        tnear: Option<&Bound<'py, PyAny>>,
        mask: Option<&Bound<'py, PyAny>>,
        ignore: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<u32>>> {
        let py = slf.py();
        let (rays, filters) = ([Some(origins), directions, tmax], [tnear, mask, ignore]);
        let query = RayQuery::of(slf, rays, filters, threads)?;
        let mut counts = vec![0; query.rays.len()];
        let (bvh, threads) = (&query.bvh, query.threads);
        query.in_pieces(py, SMALL_PIECE, |rows, filter, range| {
            let counts = &mut counts[range];
            let Some(filter) = filter else {
                return bvh.count_batch(rows, counts, threads);
            };
            let lists = bvh.all_hits_batch_filtered(rows, &filter, threads)?;
            for (ray, count) in counts.iter_mut().enumerate() {
                *count = lists.rows(ray).len() as u32;
            }
            Ok(())
        })?;
        shaped(py, counts, &query.rays.shape)
    }

    /// All hits of each ray before its tmax, in order, as AllHits.
    ///
    /// Arguments and errors as for intersect(). Rays of more than one row are
    /// numbered as in their reshape(-1, 3).
    #[pyo3(signature = (
        origins, directions=None, tmax=None, threads=None, *, tnear=None, mask=None, ignore=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn all_hits<'py>(
        slf: &Bound<'py, PyScene>,
        origins: &Bound<'py, PyAny>,
        directions: Option<&Bound<'py, PyAny>>,
        tmax: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
        tnear: Option<&Bound<'py, PyAny>>,
        mask: Option<&Bound<'py, PyAny>>,
        ignore: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<PyAllHits> {
        let py = slf.py();
        let (rays, filters) = ([Some(origins), directions, tmax], [tnear, mask, ignore]);
        let query = RayQuery::of(slf, rays, filters, threads)?;
        let mut all = HitLists::empty();
        let (bvh, threads) = (&query.bvh, query.threads);
        query.in_pieces(py, SMALL_PIECE, |rows, filter, _| {
            all.append(match filter {
                None => bvh.all_hits_batch(rows, threads)?,
                Some(filter) => bvh.all_hits_batch_filtered(rows, &filter, threads)?,
            });
            Ok(())
        })?;
        let from = RaySource::of(query.scene, origins, directions);
        PyAllHits::new(py, all, query.rays.shape, from)
    }
}
