//! Instruction sets: those that this build uses, those that this CPU has, and a guard that compares
//! the two.
//!
//! `wide` chooses its instructions at compile time, so a binary is built for one level of CPU. On a
//! lesser CPU it would die of SIGILL somewhere in the middle. [`guard`], called before anything
//! else in `main`, ends it with one clear line instead. `is_x86_feature_detected!` cannot serve
//! here: for a feature that is compiled in it is constant true.
//!
//! The guard itself is compiled with the instructions for which it checks. So it is written as
//! scalar steps, one `cpuid` word and one mask at a time. Each word is taken through
//! [`black_box`](std::hint::black_box) from a function of its own. There is no array to vectorise,
//! no struct to copy through a vector register, no shift by a variable that BMI2 would take, and no
//! formatting. `tests/engine/isa_guard.rs` runs it under emulated lesser CPUs.

/// One instruction-set extension that the compiler may have been allowed to use.
#[cfg_attr(
    not(target_arch = "x86_64"),
    allow(dead_code, reason = "only x86-64 has cpuid")
)]
#[derive(Clone, Copy, Debug)]
struct Feature {
    /// Name in `-C target-feature`.
    name: &'static str,
    /// True if this build uses it.
    compiled: bool,
    /// Word of cpuid that reports it.
    word: Word,
    /// The bit of that word.
    mask: u32,
    /// First x86-64 level that includes it; 0 if none does.
    level: u8,
}

/// The words of cpuid that report features.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    /// Leaf 1, ECX.
    Basic,
    /// Leaf 7, EBX.
    Structured,
    /// Leaf 7, ECX.
    StructuredC,
    /// Leaf 7, EDX.
    StructuredD,
    /// Leaf 7, subleaf 1, EAX.
    Later,
    /// Leaf 0x8000_0001, ECX.
    Extended,
}

macro_rules! features {
    ($($word:ident { $($name:literal $bit:literal $level:literal,)* })*) => {
        [$($(Feature {
            name: $name,
            compiled: cfg!(target_feature = $name),
            word: Word::$word,
            mask: 1 << $bit,
            level: $level,
        },)*)*]
    };
}

/// All features that `target-cpu=native` may enable and code may then use without a check: name,
/// bit, level. Omits xsaveopt, xsavec and xsaves, which only operating systems use and hypervisors
/// often hide.
#[rustfmt::skip]
const TABLE: &[Feature] = &features! {
    Basic {
        "sse3" 0 2, "pclmulqdq" 1 0, "ssse3" 9 2, "fma" 12 3, "cmpxchg16b" 13 2, "sse4.1" 19 2, "sse4.2" 20 2,
        "movbe" 22 3, "popcnt" 23 2, "aes" 25 0, "xsave" 26 0, "avx" 28 3, "f16c" 29 3, "rdrand" 30 0,
    }
    Structured {
        "bmi1" 3 3, "avx2" 5 3, "bmi2" 8 3, "avx512f" 16 4, "avx512dq" 17 4, "rdseed" 18 0, "adx" 19 0,
        "avx512ifma" 21 0, "avx512cd" 28 4, "sha" 29 0, "avx512bw" 30 4, "avx512vl" 31 4,
    }
    StructuredC {
        "avx512vbmi" 1 0, "avx512vbmi2" 6 0, "gfni" 8 0, "vaes" 9 0, "vpclmulqdq" 10 0, "avx512vnni" 11 0,
        "avx512bitalg" 12 0, "avx512vpopcntdq" 14 0,
    }
    StructuredD { "avx512vp2intersect" 8 0, "avx512fp16" 23 0, }
    Later { "avxvnni" 4 0, "avx512bf16" 5 0, "avxifma" 23 0, }
    Extended { "lzcnt" 5 3, "sse4a" 6 0, "tbm" 21 0, }
};

/// The table in memory: a loop over it reads one scalar at a time.
static FEATURES: &[Feature] = TABLE;

/// The x86-64 levels of the psABI, by number.
const LEVELS: [&str; 5] = ["", "x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"];

/// Level of this build.
const COMPILED: u8 = {
    let mut level = 4;
    let mut i = 0;
    while i < TABLE.len() {
        if !TABLE[i].compiled && TABLE[i].level != 0 && TABLE[i].level <= level {
            level = TABLE[i].level - 1;
        }
        i += 1;
    }
    level
};

/// The instruction-set level for which this build was compiled: `x86-64` to `x86-64-v4`, elsewhere
/// the architecture's name.
pub const fn compiled_level() -> &'static str {
    if cfg!(target_arch = "x86_64") {
        LEVELS[COMPILED as usize]
    } else {
        std::env::consts::ARCH
    }
}

/// The level of this CPU, named as by [`compiled_level`].
pub fn cpu_level() -> &'static str {
    if cfg!(target_arch = "x86_64") {
        LEVELS[cpu::level() as usize]
    } else {
        std::env::consts::ARCH
    }
}

/// Advice on build settings if this build leaves instructions of this CPU unused; else `None`.
pub fn advice() -> Option<String> {
    let unused = cfg!(target_arch = "x86_64") && COMPILED < cpu::level();
    unused.then(|| {
        format!(
            "built for {}, but this CPU has {}: building with RUSTFLAGS=\"-C target-cpu=native\" makes it faster",
            compiled_level(),
            cpu_level()
        )
    })
}

/// State of an instruction-set extension with this build and this CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extension {
    /// Name in `-C target-feature`.
    pub name: &'static str,
    /// True if this build uses it.
    pub compiled: bool,
    /// True if this CPU has it.
    pub present: bool,
}

/// Every extension that [`guard`] checks; none if the architecture is not x86-64.
pub fn extensions() -> Vec<Extension> {
    let known = if cfg!(target_arch = "x86_64") { FEATURES } else { &[] };
    let stand = |f: &Feature| Extension {
        name: f.name,
        compiled: f.compiled,
        present: cpu::has(f),
    };
    known.iter().map(stand).collect()
}

/// Size in bytes of the data cache nearest to a core; `None` if neither the processor nor the
/// system reports it.
pub fn nearest_cache() -> Option<usize> {
    cpu::nearest_cache()
}

/// Size in bytes of a cache, as reported by the processor.
#[cfg(target_arch = "x86_64")]
pub fn cache_bytes(cache: &raw_cpuid::CacheParameter) -> usize {
    let lines = cache.sets() * cache.associativity() * cache.physical_line_partitions();
    lines * cache.coherency_line_size()
}

/// Ends the process, with one line on stderr and exit code 1, if this CPU lacks what this build
/// uses.
///
/// Call it before anything else, from a `main` that does nothing itself. It has no effect on other
/// architectures: their builds are for the baseline CPU, unless RUSTFLAGS ask for more.
#[inline(never)]
pub fn guard() {
    if let Some(feature) = missing() {
        refuse(feature);
    }
}

/// Returns true if this CPU has all that this build uses, as [`guard`] finds out: for libraries,
/// whose first call should refuse and not end the process.
#[inline(never)]
pub fn runs_here() -> bool {
    missing().is_none()
}

/// The first feature that this build uses and this CPU lacks.
#[inline(never)]
fn missing() -> Option<&'static Feature> {
    let mut features = FEATURES.iter();
    features.find(|feature| feature.compiled && !cpu::has(feature))
}

#[cold]
#[inline(never)]
fn refuse(missing: &Feature) -> ! {
    say("phalanx: this build uses ");
    say(missing.name);
    say(", which this CPU lacks; build it for this CPU with RUSTFLAGS=\"-C target-cpu=");
    say(LEVELS[cpu::level() as usize]);
    say("\" cargo build --release\n");
    std::process::exit(1)
}

/// Prints text unformatted and unbuffered, for [`refuse`]. If stderr is closed, there is no way to
/// report.
#[inline(never)]
fn say(text: &str) {
    use std::io::Write;
    let _ = std::io::stderr().write_all(text.as_bytes());
}

#[cfg(target_arch = "x86_64")]
mod cpu {
    use super::{FEATURES, Feature, Word};
    use raw_cpuid::{CacheType, CpuId};
    use std::hint::black_box;

    /// Returns true if this CPU has a feature.
    #[inline(never)]
    pub fn has(feature: &Feature) -> bool {
        black_box(word(feature.word)) & feature.mask != 0
    }

    /// See [`super::nearest_cache`].
    pub fn nearest_cache() -> Option<usize> {
        let caches = CpuId::new().get_cache_parameters()?;
        let mut nearest = caches.filter(|c| c.level() == 1 && c.cache_type() == CacheType::Data);
        nearest.next().map(|c| super::cache_bytes(&c))
    }

    /// Level of this CPU: one below the first level that includes a feature it lacks.
    #[inline(never)]
    pub fn level() -> u8 {
        let mut level = 4;
        for feature in FEATURES {
            if feature.level != 0 && feature.level <= level && !has(feature) {
                level = feature.level - 1;
            }
        }
        level
    }

    /// Features of [`Word::Basic`] that need the wide registers: fma, avx, f16c.
    const WIDE: u32 = 1 << 12 | 1 << 28 | 1 << 29;
    /// Bit of OSXSAVE, in the same word: the system saves the wide registers.
    const SYSTEM_KEEPS_WIDE: u32 = 1 << 27;

    /// A word of cpuid; 0 if the CPU does not support its leaf.
    ///
    /// A CPU with AVX counts as having none if the system does not save its registers. (A system
    /// that saves AVX registers but not those of AVX-512 goes unnoticed: detecting it takes
    /// `xgetbv`, which needs unsafe code.)
    #[inline(never)]
    fn word(which: Word) -> u32 {
        match which {
            Word::Basic => {
                let word = black_box(leaf(1, 0, Register::C));
                if word & SYSTEM_KEEPS_WIDE != 0 { word } else { word & !WIDE }
            }
            Word::Structured => leaf(7, 0, Register::B),
            Word::StructuredC => leaf(7, 0, Register::C),
            Word::StructuredD => leaf(7, 0, Register::D),
            Word::Later => leaf(7, 1, Register::A),
            Word::Extended => leaf(0x8000_0001, 0, Register::C),
        }
    }

    #[derive(Clone, Copy)]
    enum Register {
        A,
        B,
        C,
        D,
    }

    #[inline(never)]
    fn leaf(leaf: u32, subleaf: u32, register: Register) -> u32 {
        // The first leaf of each range gives the last; beyond it, Intel CPUs return the values of
        // another leaf.
        let last = black_box(raw_cpuid::native_cpuid::cpuid_count(leaf & 0x8000_0000, 0).eax);
        if last < leaf {
            return 0;
        }
        let words = raw_cpuid::native_cpuid::cpuid_count(leaf, subleaf);
        match register {
            Register::A => black_box(words.eax),
            Register::B => black_box(words.ebx),
            Register::C => black_box(words.ecx),
            Register::D => black_box(words.edx),
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod cpu {
    use super::Feature;

    pub fn has(_: &Feature) -> bool {
        true
    }

    pub fn nearest_cache() -> Option<usize> {
        crate::cpu_caches::nearest_data_cache()
    }

    pub fn level() -> u8 {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_cpu_has_what_this_build_uses() {
        for extension in extensions() {
            assert!(extension.present || !extension.compiled, "{extension:?}");
        }
        guard();
    }

    /// Compares with the size that Linux reports, if it does.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn the_nearest_cache_is_as_large_as_the_system_says() {
        let cache = std::path::Path::new("/sys/devices/system/cpu/cpu0/cache/index0");
        let attributes =
            ["type", "level", "size"].map(|name| std::fs::read_to_string(cache.join(name)));
        let [Ok(kind), Ok(level), Ok(size)] = attributes else {
            return;
        };
        if (kind.trim(), level.trim()) != ("Data", "1") {
            return;
        }
        let size: usize = size.trim().trim_end_matches('K').parse().unwrap();
        assert_eq!(nearest_cache(), Some(size << 10));
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn cpuid_is_read_as_the_standard_library_reads_it() {
        // In a build that has the feature compiled in, this is constant true and shows nothing; the
        // baseline build's run of this test does.
        let expected = [
            ("sse3", is_x86_feature_detected!("sse3")),
            ("popcnt", is_x86_feature_detected!("popcnt")),
            ("avx", is_x86_feature_detected!("avx")),
            ("avx2", is_x86_feature_detected!("avx2")),
            ("fma", is_x86_feature_detected!("fma")),
            ("bmi1", is_x86_feature_detected!("bmi1")),
            ("bmi2", is_x86_feature_detected!("bmi2")),
            ("lzcnt", is_x86_feature_detected!("lzcnt")),
            ("sha", is_x86_feature_detected!("sha")),
            ("adx", is_x86_feature_detected!("adx")),
            ("sse4a", is_x86_feature_detected!("sse4a")),
            ("avx512f", is_x86_feature_detected!("avx512f")),
            ("avx512vl", is_x86_feature_detected!("avx512vl")),
            ("avx512bf16", is_x86_feature_detected!("avx512bf16")),
            ("avx512vbmi2", is_x86_feature_detected!("avx512vbmi2")),
            ("avx512fp16", is_x86_feature_detected!("avx512fp16")),
            (
                "avx512vp2intersect",
                is_x86_feature_detected!("avx512vp2intersect"),
            ),
            ("avxvnni", is_x86_feature_detected!("avxvnni")),
            ("gfni", is_x86_feature_detected!("gfni")),
            ("vpclmulqdq", is_x86_feature_detected!("vpclmulqdq")),
        ];
        for (name, present) in expected {
            let extension = extensions().into_iter().find(|e| e.name == name);
            assert_eq!(extension.map(|e| e.present), Some(present), "{name}");
        }
    }

    #[test]
    fn levels_are_named() {
        assert!(cpu_level() >= compiled_level());
        assert_eq!(advice().is_some(), cpu_level() != compiled_level());
        if cfg!(all(
            target_feature = "avx2",
            not(target_feature = "avx512f")
        )) {
            assert_eq!(compiled_level(), "x86-64-v3");
        }
        if cfg!(not(target_feature = "sse3")) && cfg!(target_arch = "x86_64") {
            assert_eq!(compiled_level(), "x86-64");
        }
    }
}
