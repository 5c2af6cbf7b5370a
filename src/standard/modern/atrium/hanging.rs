//! Hanging things: lanterns on chains, ropes across the court, and lamps on them.

use super::layout::{BAY, GROUND, HALF, LAMPS, LANTERNS, UPPER, Wing};
use super::palette::{BRASS, FLAME, IRON, ROPE};
use super::turning::{beam, flat, plain, revolve, ring};
use crate::builder::StandardLight;
use crate::modern::materials::rgb;
use crate::modern::props::{FramePoint, PartBuilder};
use crate::modern::setup::lamp;
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;

/// Height of a lantern's flame, and distance of the lanterns from the columns' line.
const FLAMES: f64 = 2.95;
const BEHIND: f64 = -1.8;

/// Light of the lantern of a bay, from beneath its cage.
pub(super) fn light(wing: &Wing, bay: u32) -> StandardLight {
    let x = BAY * (f64::from(bay) + 0.5);
    let position = wing.frame.point(dvec3(x, FLAMES - 0.4, BEHIND));
    lamp(position, rgb(0.85, 0.52, 0.22), 1.7)
}

/// The lanterns in the aisle of a wing.
pub(super) fn lanterns(parts: &mut PartBuilder, wing: &Wing) {
    if parts.detail < LANTERNS {
        return;
    }
    for k in 0..wing.bays {
        let x = BAY * (f64::from(k) + 0.5);
        lantern(&mut parts.moved(x, FLAMES, BEHIND));
    }
}

fn lantern(parts: &mut PartBuilder) {
    let crown = GROUND.spring + 1.42 - FLAMES;
    parts.material(IRON);
    chain(parts, 0.3, crown);
    parts.material(BRASS);
    let roof = [
        (0.17, 0.16),
        (0.15, 0.2),
        (0.06, 0.24),
        (0.05, 0.29),
        (0.01, 0.32),
    ];
    revolve(parts, &roof, (6, 2), plain);
    let foot = [
        (0.02, -0.24),
        (0.05, -0.2),
        (0.1, -0.17),
        (0.15, -0.16),
        (0.13, -0.14),
    ];
    revolve(parts, &foot, (6, 2), plain);
    let mut cage = flat(parts);
    for k in 0..6 {
        let post = cage.frame.turned(60.0 * f64::from(k));
        let ends = [(0.13, -0.15, 0.0), (0.155, 0.17, 0.0)];
        beam(&mut cage.at(post), ends, (0.012, 0.012));
    }
    parts.material(FLAME);
    let flame = [(0.03, -0.12), (0.075, -0.04), (0.06, 0.06), (0.006, 0.15)];
    revolve(parts, &flame, (6, 3), plain);
}

/// A chain between two heights: its links are rings, and a thin rod where detail is low.
fn chain(parts: &mut PartBuilder, from: f64, to: f64) {
    if parts.detail < 8.0 {
        let ends = [(0.0, from, 0.0), (0.0, to, 0.0)];
        return beam(parts, ends, (0.02, 0.02));
    }
    let pitch = 0.075;
    let links = ((to - from) / pitch).round();
    let wire = (
        parts.cells(TAU * 0.008).max(4),
        parts.cells(TAU * 0.03).max(8),
    );
    for k in 0..links as u32 {
        let y = from + pitch * (f64::from(k) + 0.5);
        let mut link = parts.moved(0.0, y, 0.0);
        link.frame = link.frame.turned(90.0 * f64::from(k % 2));
        ring(&mut link, (0.026, 0.046), 0.0075, wire);
    }
}

/// Ropes between the upper columns of both long sides: two from corner to corner, the others
/// slantwise from bay to bay. They are straight, and as long as the court.
pub(super) fn ropes(parts: &mut PartBuilder, bays: u32) {
    let long = BAY * f64::from(bays) / 2.0;
    let (high, x) = (UPPER.top - 0.4, HALF - 0.3);
    for side in [-1.0, 1.0] {
        let ends = [
            (-x * side, high, -long + 0.3),
            (x * side, high + 0.1 * side, long - 0.3),
        ];
        line(parts, ends, 4 * bays);
    }
    for k in 0..bays / 2 {
        let z = BAY * f64::from(2 * k) - long;
        let near = z + 2.0 * BAY;
        let ends = match k % 2 {
            0 => [(-x, 7.6, z + 0.4), (x, 8.3, near - 0.4)],
            _ => [(-x, 8.3, near - 0.4), (x, 7.6, z + 0.4)],
        };
        line(parts, ends, 14);
    }
}

/// A rope with small lamps on it.
fn line(parts: &mut PartBuilder, ends: [FramePoint; 2], lamps: u32) {
    parts.material(ROPE);
    beam(parts, ends, (0.022, 0.022));
    if parts.detail < LAMPS {
        return;
    }
    let [from, to] = ends.map(DVec3::from);
    for k in 0..lamps {
        let lamp = from + (to - from) * ((f64::from(k) + 0.5) / f64::from(lamps));
        let mut bulb = parts.moved(lamp.x, lamp.y - 0.19, lamp.z);
        bulb.material(BRASS);
        let cap = [(0.04, 0.1), (0.03, 0.13), (0.012, 0.19)];
        revolve(&mut bulb, &cap, (4, 1), plain);
        bulb.material(FLAME);
        let globe = [(0.012, -0.06), (0.065, -0.05), (0.08, 0.03), (0.04, 0.1)];
        revolve(&mut bulb, &globe, (5, 3), plain);
    }
}
