//! A mesh, a sphere, one ray, and one shadow ray: `cargo run --release --example cast_one_ray`.

use phalanx::{Bvh, Ray, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let vertices = [
        [-4.0, 0.0, -4.0],
        [4.0, 0.0, -4.0],
        [4.0, 0.0, 4.0],
        [-4.0, 0.0, 4.0],
    ];
    let floor = scene.add_mesh(&vertices, &[[0, 2, 1], [0, 3, 2]])?;
    let ball = scene.add_spheres(&[[1.0, 2.0, 0.0]], &[1.0])?;
    let bvh = Bvh::build(&scene);

    let ray = Ray::new([0.0, 4.0, 6.0], [0.1, -0.7, -1.0]);
    let Some(hit) = bvh.intersect(&ray) else {
        println!("the ray hits nothing");
        return Ok(());
    };
    let name = match hit.geom_id {
        id if id == floor => "floor",
        id if id == ball => "ball",
        _ => "something else",
    };
    let [x, y, z] = ray.at(hit.t);
    println!(
        "hit the {name} at t = {:.3}: ({x:.3}, {y:.3}, {z:.3})",
        hit.t
    );
    println!(
        "primitive {}, u = {:.3}, v = {:.3}",
        hit.prim_id, hit.u, hit.v
    );

    // Slightly above the floor, so that the ray does not hit the floor it starts on.
    let light = [3.0, 8.0, 0.0];
    let dark = bvh.occluded(&Ray::segment([x, y + 1e-3, z], light));
    println!(
        "the light at {light:?} is {}",
        if dark { "hidden" } else { "visible" }
    );
    Ok(())
}
