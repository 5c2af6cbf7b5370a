//! Arbitrary output variables (AOVs): layers of a picture other than radiance.

/// A layer. Surface layers describe the first hit of the pixel's first camera ray. Light layers are
/// means over all camera rays, and add up to the radiance up to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Aov {
    /// Distance from the camera ray's origin, in the file's units; infinite for a miss.
    Depth,
    /// Position of the hit, in the file's coordinates relative to the scene's origin. It is not
    /// added, because far from the file's origin single precision would lose the digits that a
    /// scene has there.
    Position,
    /// Geometric normal, toward the viewer.
    Ng,
    /// Shading normal, turned with the geometric one.
    Ns,
    /// Diffuse reflectance, with its texture's colour.
    Albedo,
    /// Number of the material, an integer; [`NO_ID`] for a miss.
    Material,
    /// Number of the primitive, an integer; [`NO_ID`] for a miss.
    Primitive,
    /// Light from the surface itself (ambient, emission and the lights' contributions), or from the
    /// background.
    Direct,
    /// Light that arrives along mirror rays.
    Reflection,
    /// Light that arrives along refracted rays, or through partly transparent surfaces.
    Refraction,
    /// Number of the pixel's camera rays, an integer.
    Samples,
    /// Nodes visited by the first camera ray. This depends on the engine's tree, and slightly on
    /// the instruction set, so it is not part of the guarantee of equal bits.
    Cost,
    /// Share of the pixel that is not background: the mean, over all camera rays, of the share that
    /// ends on surfaces. With this layer, camera rays do not see the background: radiance is that
    /// of the surfaces alone, already weighted by this share (associated alpha).
    Alpha,
    /// Cryptomatte of objects: for each of the [`RANKS`] that cover most of the pixel its
    /// identifier, and the part that it covers.
    ///
    /// [`RANKS`]: crate::sampling::RANKS
    CryptoObject,
    /// Cryptomatte of materials.
    CryptoMaterial,
}

/// The number for no material or primitive.
pub const NO_ID: u32 = u32::MAX;

/// A channel of a layer: its name in a file, and true if it holds integers, as the bits of a float.
pub type AovChannel = (&'static str, bool);

const XYZ: usize = 3;

impl Aov {
    /// All layers with their names, in the order in which they are stored.
    pub const ALL: [(&'static str, Aov); 15] = [
        ("depth", Aov::Depth),
        ("position", Aov::Position),
        ("ng", Aov::Ng),
        ("ns", Aov::Ns),
        ("albedo", Aov::Albedo),
        ("material", Aov::Material),
        ("primitive", Aov::Primitive),
        ("direct", Aov::Direct),
        ("reflection", Aov::Reflection),
        ("refraction", Aov::Refraction),
        ("samples", Aov::Samples),
        ("cost", Aov::Cost),
        ("alpha", Aov::Alpha),
        ("crypto_object", Aov::CryptoObject),
        ("crypto_material", Aov::CryptoMaterial),
    ];

    /// Further names of layers: those of their channels, as other programs have them.
    pub const OTHER_NAMES: [(&'static str, Aov); 5] = [
        ("Z", Aov::Depth),
        ("P", Aov::Position),
        ("Ng", Aov::Ng),
        ("N", Aov::Ns),
        ("A", Aov::Alpha),
    ];

    /// The layer of a name of [`Aov::ALL`] or [`Aov::OTHER_NAMES`].
    pub fn named(name: &str) -> Option<Aov> {
        let mut all = Aov::ALL.iter().chain(&Aov::OTHER_NAMES);
        all.find(|(known, _)| *known == name).map(|(_, aov)| *aov)
    }

    /// Returns true if the layer is a colour or its alpha, which half floats hold well enough.
    /// Geometry, counts and identifiers need all bits of a float.
    pub fn is_color(self) -> bool {
        let light = RadianceAovs::AOVS.contains(&self);
        light || matches!(self, Aov::Albedo | Aov::Alpha)
    }

    /// The layer's channels, named as other programs look for them in OpenEXR files.
    pub fn channels(self) -> &'static [AovChannel] {
        match self {
            Aov::Depth => &[("Z", false)],
            Aov::Position => &[("P.X", false), ("P.Y", false), ("P.Z", false)],
            Aov::Ng => &[("Ng.X", false), ("Ng.Y", false), ("Ng.Z", false)],
            Aov::Ns => &[("N.X", false), ("N.Y", false), ("N.Z", false)],
            Aov::Albedo => &[
                ("albedo.R", false),
                ("albedo.G", false),
                ("albedo.B", false),
            ],
            Aov::Material => &[("material.id", true)],
            Aov::Primitive => &[("primitive.id", true)],
            Aov::Direct => &[
                ("direct.R", false),
                ("direct.G", false),
                ("direct.B", false),
            ],
            Aov::Reflection => &[
                ("reflection.R", false),
                ("reflection.G", false),
                ("reflection.B", false),
            ],
            Aov::Refraction => &[
                ("refraction.R", false),
                ("refraction.G", false),
                ("refraction.B", false),
            ],
            Aov::Samples => &[("samples.count", true)],
            Aov::Cost => &[("cost.nodes", false)],
            Aov::Alpha => &[("A", false)],
            Aov::CryptoObject => &[
                ("CryptoObject00.R", false),
                ("CryptoObject00.G", false),
                ("CryptoObject00.B", false),
                ("CryptoObject00.A", false),
                ("CryptoObject01.R", false),
                ("CryptoObject01.G", false),
                ("CryptoObject01.B", false),
                ("CryptoObject01.A", false),
                ("CryptoObject02.R", false),
                ("CryptoObject02.G", false),
                ("CryptoObject02.B", false),
                ("CryptoObject02.A", false),
            ],
            Aov::CryptoMaterial => &[
                ("CryptoMaterial00.R", false),
                ("CryptoMaterial00.G", false),
                ("CryptoMaterial00.B", false),
                ("CryptoMaterial00.A", false),
                ("CryptoMaterial01.R", false),
                ("CryptoMaterial01.G", false),
                ("CryptoMaterial01.B", false),
                ("CryptoMaterial01.A", false),
                ("CryptoMaterial02.R", false),
                ("CryptoMaterial02.G", false),
                ("CryptoMaterial02.B", false),
                ("CryptoMaterial02.A", false),
            ],
        }
    }
}

/// Channel names in files of version 0.1 and earlier, with their current names.
const RENAMED_CHANNELS: [(&str, &str); 10] = [
    ("depth.Z", "Z"),
    ("position.X", "P.X"),
    ("position.Y", "P.Y"),
    ("position.Z", "P.Z"),
    ("ng.X", "Ng.X"),
    ("ng.Y", "Ng.Y"),
    ("ng.Z", "Ng.Z"),
    ("ns.X", "N.X"),
    ("ns.Y", "N.Y"),
    ("ns.Z", "N.Z"),
];

/// The current name of a channel, for readers of files with earlier channel names. All other names
/// are unchanged.
///
/// ```
/// # extern crate phalanx_scene as phalanx;
/// use phalanx::film::current_channel_name;
///
/// assert_eq!(current_channel_name("ns.X"), "N.X");
/// assert_eq!(current_channel_name("albedo.R"), "albedo.R");
/// ```
pub fn current_channel_name(name: &str) -> &str {
    let mut renamed = RENAMED_CHANNELS.iter();
    let renaming = renamed.find(|(before, _)| *before == name);
    renaming.map_or(name, |(_, now)| now)
}

/// A set of layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Aovs(u16);

impl Aovs {
    /// The empty set.
    pub const NONE: Aovs = Aovs(0);

    /// The set with one more layer.
    #[inline]
    pub fn with(self, aov: Aov) -> Aovs {
        Aovs(self.0 | 1 << aov as u8)
    }

    /// The set of all layers that are part of the guarantee of equal bits. It has [`Aov::Alpha`],
    /// which changes radiance.
    #[inline]
    pub fn all() -> Aovs {
        let all = Aov::ALL.iter().filter(|(_, aov)| *aov != Aov::Cost);
        all.fold(Aovs::default(), |set, (_, aov)| set.with(*aov))
    }

    /// Returns true if the layer is in the set.
    #[inline]
    pub fn has(self, aov: Aov) -> bool {
        self.0 >> aov as u8 & 1 != 0
    }

    /// Returns true if the set is empty.
    #[inline]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The union of both sets.
    #[inline]
    pub fn and(self, others: Aovs) -> Aovs {
        Aovs(self.0 | others.0)
    }

    /// The set without one layer.
    #[inline]
    pub fn without(self, aov: Aov) -> Aovs {
        Aovs(self.0 & !(1 << aov as u8))
    }

    /// Returns true if the set has a layer of the first camera ray: of its surface, or its cost.
    #[inline]
    pub fn of_surface(self) -> bool {
        let those = [Aov::Depth, Aov::Position, Aov::Ng, Aov::Ns, Aov::Albedo];
        let numbers = [Aov::Material, Aov::Primitive, Aov::Cost];
        those.into_iter().chain(numbers).any(|aov| self.has(aov))
    }

    /// Returns true if the set has a light layer.
    #[inline]
    pub fn of_light(self) -> bool {
        RadianceAovs::AOVS.into_iter().any(|aov| self.has(aov))
    }

    /// Returns true if the set has a layer of the surfaces that all camera rays see.
    #[inline]
    pub fn of_coverage(self) -> bool {
        self.has(Aov::Alpha) || self.of_mattes()
    }

    /// Returns true if the set has a layer of identifiers.
    #[inline]
    pub fn of_mattes(self) -> bool {
        self.has(Aov::CryptoObject) || self.has(Aov::CryptoMaterial)
    }

    /// The layers of the set, in their order.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = Aov> {
        let all = Aov::ALL.into_iter().map(|(_, aov)| aov);
        all.filter(move |aov| self.has(*aov))
    }

    /// The channels of all layers of the set, in their order.
    #[inline]
    pub fn channels(self) -> impl Iterator<Item = AovChannel> {
        self.iter().flat_map(|aov| aov.channels().iter().copied())
    }

    /// Number of channels before those of a layer.
    #[inline]
    pub(super) fn before(self, aov: Aov) -> usize {
        let before = self.iter().take_while(|other| *other != aov);
        before.map(|other| other.channels().len()).sum()
    }
}

/// Values of the surface layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceAov {
    /// [`Aov::Depth`].
    pub depth: f32,
    /// [`Aov::Position`].
    pub position: [f32; XYZ],
    /// [`Aov::Ng`].
    pub ng: [f32; XYZ],
    /// [`Aov::Ns`].
    pub ns: [f32; XYZ],
    /// [`Aov::Albedo`].
    pub albedo: [f32; XYZ],
    /// [`Aov::Material`].
    pub material: u32,
    /// [`Aov::Primitive`].
    pub primitive: u32,
}

impl SurfaceAov {
    /// The values for a miss.
    pub const NONE: SurfaceAov = SurfaceAov {
        depth: f32::INFINITY,
        position: [0.0; XYZ],
        ng: [0.0; XYZ],
        ns: [0.0; XYZ],
        albedo: [0.0; XYZ],
        material: NO_ID,
        primitive: NO_ID,
    };

    /// The channels of a layer; none if it is not a surface layer.
    pub(super) fn channels(&self, aov: Aov) -> ([f32; XYZ], usize) {
        let one = |value: f32| ([value, 0.0, 0.0], 1);
        match aov {
            Aov::Depth => one(self.depth),
            Aov::Position => (self.position, XYZ),
            Aov::Ng => (self.ng, XYZ),
            Aov::Ns => (self.ns, XYZ),
            Aov::Albedo => (self.albedo, XYZ),
            Aov::Material => one(f32::from_bits(self.material)),
            Aov::Primitive => one(f32::from_bits(self.primitive)),
            _ => ([0.0; XYZ], 0),
        }
    }
}

/// Radiance by the path along which it came: the values of the light layers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadianceAovs(pub [[f32; XYZ]; 3]);

impl RadianceAovs {
    /// The layers of the rows, in order.
    pub const AOVS: [Aov; 3] = [Aov::Direct, Aov::Reflection, Aov::Refraction];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_come_in_the_order_of_the_layers() {
        let set = Aovs::default()
            .with(Aov::Material)
            .with(Aov::Ns)
            .with(Aov::Depth);
        let names: Vec<_> = set.channels().map(|(name, _)| name).collect();
        assert_eq!(names, ["Z", "N.X", "N.Y", "N.Z", "material.id"]);
        assert_eq!(
            [Aov::Depth, Aov::Ns, Aov::Material].map(|aov| set.before(aov)),
            [0, 1, 4]
        );
        for (k, (_, aov)) in Aov::ALL.into_iter().enumerate() {
            assert_eq!(aov as usize, k);
        }
        for (before, now) in RENAMED_CHANNELS {
            assert!(Aovs::all().channels().any(|(name, _)| name == now), "{now}");
            assert!(Aovs::all().channels().all(|(name, _)| name != before));
        }
        let all = Aovs::all();
        assert!(all.of_light() && all.of_surface() && !all.has(Aov::Cost));
        let samples = Aovs::default().with(Aov::Samples);
        assert!(!samples.of_light() && !samples.of_surface() && !samples.is_empty());
    }
}
