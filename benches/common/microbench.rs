//! Microbenchmarks: sixty-four primitives of one kind, a thousand rays, and every engine's result
//! in one form.

use super::rng::Rng;
use glam::{Affine3A, Mat3, Vec3};
use phalanx::bvh::Bvh;
use phalanx::lanes::{F32x8, F32x16, LANES, LaneMask, Lanes, Vec3Lanes};
use phalanx::oracle::{self, OracleHit, OracleRay};
use phalanx::packet::{HitPacket, NO_PRIM, RayPacket};
use phalanx::scene::{Bounds, Cone, Material, PrimKind, Scene};
use phalanx::trace::PacketLanes;

/// Number of rays of every test.
pub const RAYS: usize = 1024;
/// Number of boxes or primitives that each ray is tested against.
pub const TARGETS: usize = 64;

/// The measured test.
#[derive(Clone, Copy, PartialEq)]
pub enum Test {
    /// Intersection with boxes.
    Boxes,
    /// The closest hit on primitives of a kind.
    Closest(PrimKind),
    /// Occlusion by primitives of a kind, up to half of the distance at which a ray could hit one.
    Occluded(PrimKind),
}

impl Test {
    /// Every test by name.
    pub const ALL: [(&'static str, Test); 9] = [
        ("box", Test::Boxes),
        ("triangle closest", Test::Closest(PrimKind::Triangle)),
        ("triangle occluded", Test::Occluded(PrimKind::Triangle)),
        ("sphere closest", Test::Closest(PrimKind::Sphere)),
        ("sphere occluded", Test::Occluded(PrimKind::Sphere)),
        ("ellipsoid closest", Test::Closest(PrimKind::Ellipsoid)),
        ("ellipsoid occluded", Test::Occluded(PrimKind::Ellipsoid)),
        ("cone closest", Test::Closest(PrimKind::Cone)),
        ("cone occluded", Test::Occluded(PrimKind::Cone)),
    ];

    fn kind(self) -> PrimKind {
        match self {
            // The boxes of spheres represent those of all kinds, which have similar sizes.
            Test::Boxes => PrimKind::Sphere,
            Test::Closest(kind) | Test::Occluded(kind) => kind,
        }
    }
}

/// The arrangement of the rays.
#[derive(Clone, Copy, PartialEq)]
pub enum Order {
    /// Rays from one eye through the cells of a grid, with neighbours in a packet. All directions
    /// agree in sign and in their longest axis, so that boxes are tested in order and triangles in
    /// one frame.
    Coherent,
    /// Unrelated rays.
    Scattered,
}

impl Order {
    /// Both orders by name.
    pub const ALL: [(&'static str, Order); 2] = [
        ("coherent", Order::Coherent),
        ("scattered", Order::Scattered),
    ];

    fn rays(self) -> Vec<OracleRay> {
        let mut rng = Rng::new(3);
        let ray = |k: usize| match self {
            Order::Coherent => {
                let (x, y) = (k / LANES % 8 * 4 + k % 4, k / LANES / 8 * 2 + k % LANES / 4);
                let coordinate = |cell: usize| (cell as f32 + 0.5) / 16.0 - 1.0;
                let to = Vec3::new(coordinate(x), coordinate(y), 0.0);
                unit(EYE, to - EYE)
            }
            Order::Scattered => {
                let org = rng.point(1.5);
                let dir = rng.direction();
                OracleRay::new(org, dir)
            }
        };
        (0..RAYS).map(ray).collect()
    }

    /// A distance near the middle of those at which the rays can hit.
    fn middle(self) -> f32 {
        match self {
            Order::Coherent => EYE.length(),
            Order::Scattered => 0.5,
        }
    }
}

const EYE: Vec3 = Vec3::new(4.0, 5.0, 9.0);

fn unit(org: Vec3, dir: Vec3) -> OracleRay {
    OracleRay::new(org, dir / dir.dot(dir).sqrt())
}

/// The result of a test, the same for every engine.
#[derive(Clone, Debug, PartialEq)]
pub enum TestOutcome {
    /// Number of pairs of a ray and a box that intersect.
    Met(u64),
    /// The hit of every ray: the bits of t, u and v, and the primitive.
    Hits(Vec<Option<[u32; 4]>>),
    /// Occlusion of each ray.
    Blocked(Vec<bool>),
}

impl TestOutcome {
    /// Checksum of the result; equal results have equal checksums in every build.
    pub fn checksum(&self) -> u64 {
        let mix = |sum: u64, word: u32| {
            (sum ^ u64::from(word))
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(29)
        };
        match self {
            TestOutcome::Met(met) => *met,
            TestOutcome::Hits(hits) => hits.iter().fold(1, |sum, hit| {
                hit.unwrap_or([u32::MAX; 4]).into_iter().fold(sum, mix)
            }),
            TestOutcome::Blocked(blocked) => blocked.iter().fold(2, |sum, &b| mix(sum, b.into())),
        }
    }

    /// Number of rays that hit anything, or of pairs that intersect.
    pub fn met(&self) -> usize {
        match self {
            TestOutcome::Met(met) => *met as usize,
            TestOutcome::Hits(hits) => hits.iter().flatten().count(),
            TestOutcome::Blocked(blocked) => blocked.iter().filter(|&&b| b).count(),
        }
    }
}

/// One test by one engine, with everything prepared.
pub trait EngineTest {
    /// Tests all rays against all targets.
    fn run(&mut self);
    /// The result of the last run.
    fn answer(&self) -> TestOutcome;
}

/// The prepared test of every engine, by name.
pub fn trials(test: Test, order: Order) -> [(&'static str, Box<dyn EngineTest>); 3] {
    [
        ("8 lanes", eight(test, order)),
        (
            "16 lanes",
            Box::new(PacketEngineTest::<F32x16>::new(test, order)),
        ),
        ("oracle", one_by_one(test, order)),
    ]
}

/// The test by packets of eight lanes.
pub fn eight(test: Test, order: Order) -> Box<dyn EngineTest> {
    Box::new(PacketEngineTest::<F32x8>::new(test, order))
}

/// The test by the oracle.
pub fn one_by_one(test: Test, order: Order) -> Box<dyn EngineTest> {
    Box::new(OracleEngineTest::new(test, order))
}

/// The packet engine's test.
struct PacketEngineTest<L: Lanes> {
    test: Test,
    targets: Bvh,
    boxes: Vec<[[f32; 3]; 2]>,
    rays: Vec<RayPacket<L>>,
    met: u64,
    hits: Vec<HitPacket<L>>,
    blocked: Vec<u32>,
}

impl<L: Lanes> PacketEngineTest<L> {
    fn new(test: Test, order: Order) -> PacketEngineTest<L> {
        let scene = targets(test.kind());
        let tmax = match test {
            Test::Occluded(_) => order.middle(),
            _ => f32::INFINITY,
        };
        let rays = packets(&order.rays(), tmax);
        PacketEngineTest {
            test,
            boxes: boxes(&scene)
                .iter()
                .map(|b| [b.lo.to_array(), b.hi.to_array()])
                .collect(),
            targets: Bvh::build(&scene),
            met: 0,
            hits: vec![nothing(); rays.len()],
            blocked: vec![0; rays.len()],
            rays,
        }
    }
}

impl<L: PacketLanes> EngineTest for PacketEngineTest<L> {
    fn run(&mut self) {
        let (targets, rays) = (&self.targets, &self.rays);
        let (hits, blocked) = (&mut self.hits, &mut self.blocked);
        match self.test {
            Test::Boxes => self.met = (L::functions().test_boxes)(rays, &self.boxes),
            Test::Closest(kind) => (L::functions().test_closest)(targets, kind, rays, hits),
            Test::Occluded(kind) => (L::functions().test_occluded)(targets, kind, rays, blocked),
        }
    }

    fn answer(&self) -> TestOutcome {
        match self.test {
            Test::Boxes => TestOutcome::Met(self.met),
            Test::Closest(_) => TestOutcome::Hits(
                self.hits
                    .iter()
                    .flat_map(|packet| (0..L::PACKETS).flat_map(|k| lanes(&packet.octet(k))))
                    .collect(),
            ),
            Test::Occluded(_) => {
                let lanes = L::PACKETS * LANES;
                let bit = |k: usize| self.blocked[k / lanes] >> (k % lanes) & 1 == 1;
                TestOutcome::Blocked((0..RAYS).map(bit).collect())
            }
        }
    }
}

/// The bits of each lane's hit.
pub fn lanes(hits: &HitPacket) -> [Option<[u32; 4]>; LANES] {
    std::array::from_fn(|lane| {
        let prim_id = hits.prim_id.lane(lane);
        let bits = |column: &F32x8| column.lane(lane).to_bits();
        (prim_id != NO_PRIM).then(|| [bits(&hits.t), bits(&hits.u), bits(&hits.v), prim_id])
    })
}

/// The bits of the oracle's hit.
pub fn hit_bits(hit: &OracleHit) -> [u32; 4] {
    [
        hit.t.to_bits(),
        hit.u.to_bits(),
        hit.v.to_bits(),
        hit.prim_id,
    ]
}

fn nothing<L: Lanes>() -> HitPacket<L> {
    HitPacket {
        t: L::ZERO,
        u: L::ZERO,
        v: L::ZERO,
        prim_id: phalanx::lanes::LaneU32::splat(NO_PRIM),
    }
}

/// Packs rays into packets; only rays that fill packets are used.
fn packets<L: Lanes>(rays: &[OracleRay], tmax: f32) -> Vec<RayPacket<L>> {
    let component = |chunk: &[OracleRay]| {
        let column = |component: &dyn Fn(&OracleRay) -> f32| {
            L::from_octets(|eight| std::array::from_fn(|k| component(&chunk[eight * LANES + k])))
        };
        let vec = |component: fn(&OracleRay) -> Vec3| {
            Vec3Lanes::new(
                column(&|r| component(r).x),
                column(&|r| component(r).y),
                column(&|r| component(r).z),
            )
        };
        RayPacket {
            org: vec(|r| r.org),
            dir: vec(|r| r.dir),
            tmax: L::splat(tmax),
        }
    };
    let mask = L::Mask::first(L::PACKETS * LANES).bits().count_ones() as usize;
    rays.chunks_exact(mask).map(component).collect()
}

/// The oracle's test.
struct OracleEngineTest {
    test: Test,
    scene: Scene,
    boxes: Vec<Bounds>,
    rays: Vec<OracleRay>,
    tmax: f32,
    met: u64,
    hits: Vec<Option<OracleHit>>,
    blocked: Vec<bool>,
}

impl OracleEngineTest {
    fn new(test: Test, order: Order) -> OracleEngineTest {
        let scene = targets(test.kind());
        OracleEngineTest {
            test,
            boxes: boxes(&scene),
            scene,
            rays: order.rays(),
            tmax: order.middle(),
            met: 0,
            hits: vec![None; RAYS],
            blocked: vec![false; RAYS],
        }
    }
}

impl EngineTest for OracleEngineTest {
    fn run(&mut self) {
        match self.test {
            Test::Boxes => self.met = oracle::microbench::boxes(&self.rays, &self.boxes),
            Test::Closest(_) => {
                oracle::microbench::closest(&self.scene, &self.rays, &mut self.hits);
            }
            Test::Occluded(_) => {
                oracle::microbench::occluded(&self.scene, &self.rays, self.tmax, &mut self.blocked);
            }
        }
    }

    fn answer(&self) -> TestOutcome {
        match self.test {
            Test::Boxes => TestOutcome::Met(self.met),
            Test::Closest(_) => {
                let bits = |hit: &Option<OracleHit>| hit.as_ref().map(hit_bits);
                TestOutcome::Hits(self.hits.iter().map(bits).collect())
            }
            Test::Occluded(_) => TestOutcome::Blocked(self.blocked.clone()),
        }
    }
}

/// Primitives of one kind, all around the origin, large enough for a ray to hit a few.
fn targets(kind: PrimKind) -> Scene {
    let mut scene = Scene::default();
    scene.materials.push(&Material::default());
    let mut rng = Rng::new(7);
    for _ in 0..TARGETS {
        let center = rng.point(1.0);
        match kind {
            PrimKind::Triangle => {
                let corners = [0; 3].map(|_| center + rng.point(0.4));
                scene.add_triangle(corners, None, 0);
            }
            PrimKind::Sphere => {
                scene.add_sphere(center, rng.range(0.1, 0.3), 0);
            }
            PrimKind::Ellipsoid => {
                let axes = [0; 3].map(|_| rng.range(0.1, 0.4));
                add_ellipsoid(&mut scene, center, axes);
            }
            PrimKind::Cone => {
                let along = rng.direction() * rng.range(0.2, 0.6);
                let cone = Cone {
                    base: center,
                    base_radius: rng.range(0.1, 0.3),
                    apex: center + along,
                    apex_radius: rng.range(0.0, 0.3),
                    inside: false,
                };
                scene.add_cone(cone, 0);
            }
        }
    }
    scene.validate().expect("a valid scene");
    scene
}

/// Adds a slanted ellipsoid: sheared, so that its map has few zeros and needs no trigonometry.
fn add_ellipsoid(scene: &mut Scene, center: Vec3, [a, b, c]: [f32; 3]) {
    let matrix = Mat3::from_cols(
        Vec3::new(a, 0.0, 0.1),
        Vec3::new(0.2, b, 0.0),
        Vec3::new(0.0, 0.1, c),
    );
    let to_world = Affine3A::from_mat3_translation(matrix, center);
    scene.add_ellipsoid(to_world, to_world.inverse(), 0);
}

fn boxes(scene: &Scene) -> Vec<Bounds> {
    let prims = 0..scene.prim_count() as u32;
    prims.map(|prim| scene.prim_bounds(prim).padded()).collect()
}
