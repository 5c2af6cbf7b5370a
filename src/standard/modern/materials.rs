//! Materials of the modern scenes, in short form.
//!
//! The ambient term replaces the light between surfaces, which is not traced: it is a surface's
//! colour under the mean light of the sky or the room, so that shadows keep a tint.

use crate::builder::DocumentMaterial;
use glam::{DVec3, dvec3};

/// A colour.
pub(super) const fn rgb(r: f64, g: f64, b: f64) -> DVec3 {
    dvec3(r, g, b)
}

/// A matt material of this colour under this mean light.
pub(super) fn matte(color: DVec3, ambient: DVec3) -> DocumentMaterial {
    DocumentMaterial {
        ka: color * ambient,
        kd: color,
        ..DocumentMaterial::default()
    }
}

/// A material with a polish added: a highlight and a mirror image of weight `ks`.
pub(super) fn polished(material: DocumentMaterial, ks: DVec3, shininess: f64) -> DocumentMaterial {
    DocumentMaterial {
        ks,
        shininess,
        ..material
    }
}

/// Clear glass.
pub(super) fn glass(ior: f64) -> DocumentMaterial {
    DocumentMaterial {
        ks: DVec3::splat(0.1),
        kt: rgb(0.88, 0.9, 0.89),
        shininess: 500.0,
        ior,
        ..DocumentMaterial::default()
    }
}

/// A material that emits light.
pub(super) fn glow(color: DVec3) -> DocumentMaterial {
    DocumentMaterial {
        ke: color,
        ..DocumentMaterial::default()
    }
}

/// A material seen through air: at a `haze` of 0 unchanged, at 1 the colour of the air.
pub(super) fn hazy(material: DocumentMaterial, air: DVec3, haze: f64) -> DocumentMaterial {
    let clear = 1.0 - haze;
    DocumentMaterial {
        ka: material.ka * clear,
        ke: material.ke * clear + air * haze,
        kd: material.kd * clear,
        ks: material.ks * clear,
        ..material
    }
}
