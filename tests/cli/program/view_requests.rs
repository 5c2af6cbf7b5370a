//! Requests that `phalanx view` gets from browsers and from everybody else on the machine, and its
//! memory and coordinates.

use super::signals::signal;
use super::view::{ViewProcess, frame, shot};
use super::{TestFolder, ran};
use serde_json::{Value, json};
use std::fs;
use std::io::{Read, Write};
use std::os::unix::fs::PermissionsExt;

use std::time::Duration;

#[test]
fn cookies_of_other_programs_do_not_matter() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test");
    let status = |cookie: &str| {
        let more = format!("Cookie: a={cookie}\r\n");
        let reply = served.ask(&served.request(&served.address, &more, "", ""));
        (reply.status, String::from_utf8(reply.body).unwrap())
    };
    assert_eq!(status(&"0".repeat(60_000)).0, 200);
    let (code, body) = status(&"0".repeat(70_000));
    assert!(
        code == 431 && body.contains("remove the cookies"),
        "{code} {body}"
    );
    // Browsers send cookies as they are stored, in any encoding.
    let request = served.request(&served.address, "Cookie: a=?\r\n", "", "");
    let bytes: Vec<u8> = request
        .bytes()
        .map(|b| if b == b'?' { 0xe9 } else { b })
        .collect();
    let mut stream = served.connect();
    // The end of the head arrives in parts.
    for part in bytes.chunks(bytes.len() - 2) {
        stream.write_all(part).unwrap();
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut reply = Vec::new();
    stream.read_to_end(&mut reply).unwrap();
    assert!(reply.starts_with(b"HTTP/1.1 200 "));
}

#[test]
fn a_head_is_answered_as_a_get_without_its_body() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test");
    let token = &served.token;
    let mut heads = Vec::new();
    for (path, status) in [
        (format!("/{token}/"), 200),
        (format!("/{token}"), 307),
        (format!("/{token}/frame"), 404),
        ("/".to_owned(), 404),
        ("/x/".to_owned(), 404),
        (format!("/{}", "x".repeat(70_000)), 431),
    ] {
        let [get, head] = ["GET", "HEAD"].map(|method| {
            let address = &served.address;
            served.ask(&format!(
                "{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
            ))
        });
        assert_eq!((get.status, head.status), (status, status), "{path:.50}");
        assert!(head.body.is_empty(), "{path:.50}");
        assert_eq!(get.body.len().to_string(), get.header("Content-Length"));
        heads.push(head);
    }
    assert_ne!(heads[0].header("Content-Length"), "0");
    assert_eq!(heads[1].header("Location"), format!("/{token}/"));
    // Nobody without the token is led to it.
    let elsewhere =
        format!("GET /{token} HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n");
    assert_eq!(served.ask(&elsewhere).status, 404);
}

#[test]
fn connections_without_the_token_keep_nobody_out() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test");
    // One of them has sent most of a large head.
    let strangers: Vec<_> = (0..110).map(|_| served.connect()).collect();
    let mut large = &strangers[109];
    let head = format!("GET / HTTP/1.1\r\nCookie: {}", "a".repeat(60_000));
    large.write_all(head.as_bytes()).unwrap();
    for _ in 0..52 {
        assert_eq!(served.post("state", json!({})).status, 200);
    }
    drop(strangers);
}

#[test]
fn an_address_is_what_people_type() {
    let room = TestFolder::new();
    for address in ["0", "localhost:0", "127.0.0.1:0", "[::1]:0"] {
        if address.starts_with('[') && std::net::TcpListener::bind(address).is_err() {
            continue;
        }
        let served = ViewProcess::start(&room, &format!("view a.test --address {address}"));
        let host = if address.starts_with('[') { "[::1]:" } else { "127.0.0.1:" };
        assert!(served.address.starts_with(host), "{}", served.address);
    }
    for address in ["localhost", "70000", "example.org:80", "127.0.0.1"] {
        let line = format!("view a.test --address {address}");
        room.refused(&line, 2, &["IP:PORT", "127.0.0.1:8000"]);
    }
}

#[test]
fn the_file_for_the_browser_goes_with_the_program() {
    let room = TestFolder::new();
    let in_room = |name: &str| room.path().join(name);
    fs::create_dir(in_room("tmp")).unwrap();
    // A browser that notes what it gets.
    room.write("xdg-open", "#!/bin/sh\ncat \"$1\" > seen\n");
    fs::set_permissions(in_room("xdg-open"), fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:/usr/bin:/bin", room.path().display());
    let files = || fs::read_dir(in_room("tmp")).unwrap().count();
    let mut served = ViewProcess::spawn(
        room.command("view a.test --open")
            .env("TMPDIR", in_room("tmp"))
            .env("PATH", &path),
    );
    assert_eq!(files(), 1);
    signal(&served.child, "INT");
    assert_eq!(served.child.wait().unwrap().code(), Some(130));
    assert_eq!(files(), 0);
    room.write("bad.test", "sphere\n");
    let mut failing = room.command("view bad.test --open");
    let failed = ran(failing.env("TMPDIR", in_room("tmp")).env("PATH", &path));
    assert_eq!((failed.code, files()), (Some(3), 0), "{}", failed.stderr);
}

/// The largest memory of a process so far, in bytes.
#[cfg(target_os = "linux")]
fn peak(served: &ViewProcess) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", served.child.id())).unwrap();
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() << 10
}

#[cfg(target_os = "linux")]
#[test]
fn memory_stays_within_the_limit_or_nothing_is_shown() {
    let room = TestFolder::new();
    room.ok("build standard:terrain:500k -o t.phx");
    let lines = [
        "view standard:terrain:500k --max-memory 120M",
        "view t.phx --max-memory 120M",
        "view a.test --max-memory 100M --size 2000x2000",
    ];
    for line in lines {
        let ran = room.run(line);
        assert_eq!(ran.code, Some(1), "{line}: {}", ran.stderr);
        let words = "needed to view the scene, but --max-memory allows";
        assert!(ran.stderr.contains(words), "{line}: {}", ran.stderr);
    }
    // Files whose answers nobody reads.
    const LIMIT: u64 = 180_000_000;
    let line = format!("view a.test --threads 2 --max-memory {LIMIT}");
    let served = ViewProcess::start(&room, &line);
    let reply = served.post("state", json!({})).json();
    let most = reply["scene"]["most_pixels"].as_u64().unwrap();
    assert!((600_000..1_000_000).contains(&most), "{most}");
    let mut body = shot("normals", 1);
    body["size"] = json!([most / 800, 800]);
    body["page"] = json!("00112233445566aa");
    let request = served.request(&served.address, "", "save", &body.to_string());
    let streams = (0..30).map(|_| {
        let mut stream = served.connect();
        stream.write_all(request.as_bytes()).unwrap();
        stream
    });
    let streams: Vec<_> = streams.collect();
    let first = |mut stream: &std::net::TcpStream| {
        let mut head = [0; 12];
        stream.read_exact(&mut head).unwrap();
        String::from_utf8_lossy(&head[9..]).into_owned()
    };
    let statuses: Vec<String> = streams.iter().map(first).collect();
    let count = |status: &str| statuses.iter().filter(|other| *other == status).count();
    assert!(count("200") > 0 && count("503") > 0, "{statuses:?}");
    assert!(peak(&served) < LIMIT, "{}", peak(&served));
    // A reader that is gone gives its memory back.
    drop(streams);
    let mut status = 0;
    for _ in 0..500 {
        status = served.ask(&request).status;
        if status == 200 {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(status, 200);
    let mut still = frame("shaded", 0, 2);
    still["size"] = json!([most / 800, 800]);
    assert_eq!(served.post("frame", still).status, 200);
    assert!(peak(&served) < LIMIT, "{}", peak(&served));
}

/// The answer for the pixel in the middle of a scene's own view.
fn middle(served: &ViewProcess) -> (Value, Value) {
    let view = served.post("state", json!({})).json()["scene"]["view"].clone();
    let request = json!({ "view": view, "size": [64, 48], "x": 32, "y": 24, "bounds": true });
    (served.post("pixel", request).json(), view)
}

#[test]
fn a_pixel_has_the_coordinates_and_units_of_the_file() {
    let room = TestFolder::new();
    let square = |[x, y, z]: [f64; 3], side: f64| {
        let corner = |a: f64, b: f64| format!("v {} {} {z}\n", x + a * side, y + b * side);
        let corners = [
            corner(0., 0.),
            corner(1., 0.),
            corner(1., 1.),
            corner(0., 1.),
        ];
        corners.concat() + "f 1 2 3 4\n"
    };
    // A map in metres, and a model that is too small for single precision.
    let far = [456_784.25, 5_812_340.5, 33.001];
    for (name, corner, side) in [("far.obj", far, 4.0), ("tiny.obj", [0.0; 3], 1e-20)] {
        room.write(name, &square(corner, side));
        let served = ViewProcess::start(&room, &format!("view {name}"));
        let (pixel, view) = middle(&served);
        let vector = |value: &Value| [0, 1, 2].map(|axis| value[axis].as_f64().unwrap());
        let (origin, position) = (vector(&pixel["origin"]), vector(&pixel["hit"]["position"]));
        let (eye, t) = (vector(&view["eye"]), pixel["hit"]["t"].as_f64().unwrap());
        let apart =
            |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
        let near = side * 1e-5;
        assert!(apart(origin, eye) < near, "{name}: {pixel} {view}");
        assert!(
            (apart(origin, position) - t).abs() < near,
            "{name}: {pixel}"
        );
        assert!((position[2] - corner[2]).abs() < near, "{name}: {pixel}");
        let high = vector(&pixel["bounds"][1]);
        assert!(
            (high[0] - corner[0] - side).abs() < near * 10.0,
            "{name}: {pixel}"
        );
    }
}

#[test]
fn a_scene_that_cannot_be_seen_says_so_as_a_render_does() {
    let room = TestFolder::new();
    room.write("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
    let rendered = room.run("render point.obj -o x.png --size 32x32");
    assert!(
        rendered.stderr.contains("the picture is empty"),
        "{}",
        rendered.stderr
    );
    let warning = "nothing can be seen: the camera stands on the point";
    let mut command = room.command("view point.obj");
    command.stderr(fs::File::create(room.path().join("said")).unwrap());
    let served = ViewProcess::spawn_with_stderr(&mut command);
    let reply = served.post("state", json!({})).json();
    let page = reply["scene"]["warning"].as_str().unwrap();
    assert!(page.contains(warning), "{reply}");
    let stderr = fs::read_to_string(room.path().join("said")).unwrap();
    assert!(stderr.contains(warning), "{stderr}");
    // A scene that can be seen has none.
    let served = ViewProcess::start(&room, "view a.test");
    let reply = served.post("state", json!({})).json();
    assert_eq!(reply["scene"]["warning"], Value::Null);
}
