//! Lights by power, as `info` lists them.

use super::TestFolder;

/// A mesh of two triangles that glow and one that does not.
fn room() -> TestFolder {
    let room = TestFolder::new();
    room.write("a.mtl", "newmtl tube\nKe 3 3 3\nnewmtl wall\nKd 1 1 1\n");
    room.write(
        "a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl tube\nf 1 2 3\nf 2 4 3\nusemtl wall\nf 1 2 4\n",
    );
    room
}

#[test]
fn info_lists_lights_by_power_when_asked() {
    let room = room();
    assert!(!room.ok("info a.obj").contains("by power"));
    let lamps = "--light 0,0,9,.5,.5,.5 --light dir:0,3,4,.25,.25,.25";
    let rows = room.json(&format!("info a.obj {lamps} --json"))["lights_by_power"].take();
    let rows = rows.as_array().expect("a list");
    assert_eq!(rows.len(), 3, "{rows:?}");
    // π A L cos / (π d²) of both sides, by d² = 1/2.
    let weights = [3.0 / (2.0 * std::f64::consts::PI * 0.5), 0.5, 0.25];
    let sum: f64 = weights.iter().sum();
    for (row, weight) in rows.iter().zip(weights) {
        let share = row["share"].as_f64().expect("a number");
        assert!((share - weight / sum).abs() < 1e-6, "{row}");
    }
    assert_eq!(
        (&rows[0]["kind"], &rows[0]["name"]),
        (&"emission".into(), &"tube".into())
    );
    assert_eq!(rows[0]["triangles"], 2);
    assert_eq!(rows[1]["position"], serde_json::json!([0.0, 0.0, 9.0]));
    assert_eq!(rows[2]["kind"], "directional");
    let text = room.ok(&format!("info a.obj {lamps} --verbose"));
    for part in [
        "lights by power\n",
        "emission     `tube`, 2 triangles",
        "56.0 %\n",
        "from (0, 0.6, 0.8)",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_long_list_ends_with_a_sum() {
    let room = room();
    let lamps = "--light 0,0,9 ".repeat(14);
    let text = room.ok(&format!("info a.obj {lamps} --verbose"));
    let (_, list) = text.split_once("lights by power\n").expect("a list");
    assert_eq!(list.lines().count(), 13, "{list}");
    assert!(list.contains("and 3 more"), "{list}");
    // Emission of a `.test` file lights nothing, so it is not in the list.
    room.write(
        "b.test",
        "size 8 8\ncamera 0 0 5 0 0 0 0 1 0 40\npoint 9 9 9 1 1 1\nemission 1 1 1\nmaxverts 3\n\
         vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\ntri 0 1 2\n",
    );
    let text = room.ok("info b.test --verbose");
    assert!(
        text.contains("1 triangle\n") && text.contains("100.0 %"),
        "{text}"
    );
    assert!(!text.contains("emission"), "{text}");
}
