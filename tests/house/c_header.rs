//! `phalanx.h` and the library: the same functions, parameters and fields, in the same order. Both
//! sides lay structures out by the platform's rules for C, so sizes and offsets follow.

use std::collections::BTreeMap;

const HEADERS: [&str; 2] = [
    include_str!("../../src/capi/include/phalanx.h"),
    include_str!("../../src/capi/include/phalanx_files.h"),
];
const SOURCES: [&str; 8] = [
    include_str!("../../src/capi/status.rs"),
    include_str!("../../src/capi/rows.rs"),
    include_str!("../../src/capi/columns.rs"),
    include_str!("../../src/capi/scene.rs"),
    include_str!("../../src/capi/tree.rs"),
    include_str!("../../src/capi/ray.rs"),
    include_str!("../../src/capi/batch.rs"),
    include_str!("../../src/capi/hits.rs"),
];
/// Where rays and hits are, which C has from the tracer as they are.
const SHARED: [&str; 2] = [
    include_str!("../../src/trace/cast/mod.rs"),
    include_str!("../../src/trace/cast/refine.rs"),
];
const FILES: &str = include_str!("../../src/capi/files.rs");

/// Names and types of parameters or fields, in their order.
type CMembers = Vec<(String, String)>;

/// The text without comments.
fn code(header: &str) -> String {
    let mut code = String::new();
    let mut rest = header;
    while let Some((before, comment)) = rest.split_once("/*") {
        code += before;
        rest = comment.split_once("*/").expect("an end of the comment").1;
    }
    code + rest
}

/// CMembers that are declared in C, such as `const float lower[3], *upper`.
fn c_members(declarations: &str, between: char) -> CMembers {
    let mut members = CMembers::new();
    for declaration in declarations.split(between).map(str::trim) {
        if declaration.is_empty() || declaration == "void" {
            continue;
        }
        let first_name = declaration.split(',').next().expect("a name");
        let start = first_name.rfind([' ', '*']).expect("a type") + 1;
        for name in declaration[start..].split(',') {
            let name = name.trim().trim_start_matches('*');
            let (name, length) = name.split_once('[').unwrap_or((name, ""));
            let array = if length.is_empty() { "" } else { "[" };
            let kind = declaration[..start].replace(' ', "") + array + length;
            members.push((name.to_owned(), kind));
        }
    }
    members
}

/// The type in C of one in Rust, without spaces; arrays that are passed are pointers in both.
fn c_type(rust: &str) -> String {
    let numbers = [
        ("f32", "float"),
        ("f64", "double"),
        ("u32", "uint32_t"),
        ("GeomId", "uint32_t"),
        ("i32", "int32_t"),
        ("usize", "size_t"),
        ("c_int", "int"),
        ("c_char", "char"),
        ("c_void", "void"),
        ("[[f64; 4]; 3]", "double[12]"),
        ("[f32; 3]", "float[3]"),
        ("[f32; 6]", "float[6]"),
        ("[f64; 3]", "double[3]"),
    ];
    if let Some(pointed) = rust.strip_prefix("*const ") {
        return format!("const{}*", c_type(pointed));
    }
    if let Some(pointed) = rust.strip_prefix("*mut ") {
        return c_type(pointed) + "*";
    }
    let known = numbers.into_iter().find(|(name, _)| *name == rust);
    known.map_or_else(|| snake_case(rust), |(_, c)| c.to_owned())
}

/// `phx_hit_lists` of `PhxHitLists`.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(c.to_lowercase());
    }
    snake
}

/// Returns true if a type in C is the one in Rust.
fn is_same(c: &str, rust: &str) -> bool {
    let rust = c_type(rust);
    let handles = ["phx_scene", "phx_tree", "void"];
    let as_handle = handles.map(|handle| rust.replace("opaque", handle));
    // An array that is passed.
    let as_array = match rust.split_once('[') {
        Some((kind, length)) if length.ends_with("]*") => {
            format!("{kind}[{}", length.trim_end_matches('*'))
        }
        _ => rust.clone(),
    };
    as_handle.iter().any(|known| known == c) || [rust, as_array].contains(&c.to_owned())
}

/// CMembers that are declared in Rust, such as `pub t: f32, u: f32`.
fn rust_members(declarations: &str) -> CMembers {
    let lines = declarations
        .lines()
        .map(str::trim)
        .filter(|line| !line.starts_with("//"));
    let lines = lines.flat_map(|line| line.split(',')).map(str::trim);
    let lines = lines.filter(|line| line.contains(": "));
    let member = |line: &str| {
        let (name, kind) = line.split_once(": ").expect("a type");
        (name.trim_start_matches("pub ").to_owned(), kind.to_owned())
    };
    lines.map(member).collect()
}

fn assert_same(what: &str, c: &CMembers, rust: &CMembers) {
    let names = |members: &CMembers| {
        members
            .iter()
            .map(|(name, _)| name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(c), names(rust), "{what}");
    for ((name, c), (_, rust)) in c.iter().zip(rust) {
        assert!(is_same(c, rust), "{what}, {name}: {c} in C, {rust} in Rust");
    }
}

/// Functions that a header declares, without those that it defines.
fn c_functions(header: &str) -> BTreeMap<String, (String, CMembers)> {
    let mut functions = BTreeMap::new();
    for statement in code(header).split(';') {
        let Some((head, parameters)) = statement
            .rsplit_once("\n")
            .and_then(|(_, last)| last.split_once('('))
        else {
            continue;
        };
        let Some(parameters) = parameters.strip_suffix(')') else {
            continue;
        };
        let start = head.rfind([' ', '*']).map_or(0, |place| place + 1);
        let (kind, name) = head.split_at(start);
        if name.starts_with("phx_") && !head.contains("return") && !head.contains("typedef") {
            let kind = kind.replace(' ', "");
            functions.insert(name.to_owned(), (kind, c_members(parameters, ',')));
        }
    }
    functions
}

/// Functions that a file exports.
fn rust_functions(source: &str) -> BTreeMap<String, (String, CMembers)> {
    let parts = source.split("extern \"C\" fn ").skip(1);
    let functions = parts.filter(|part| part.starts_with("phx_")).map(|part| {
        let (name, rest) = part.split_once('(').expect("parameters");
        let (parameters, rest) = rest.split_once(") -> ").expect("a result");
        let kind = rest.split_once(" {").expect("a body").0;
        // Commas of arrays would part them.
        let parameters = parameters.replace(", ", ",\n");
        (
            name.to_owned(),
            (kind.to_owned(), rust_members(&parameters)),
        )
    });
    functions.collect()
}

#[test]
fn functions_of_the_header_are_those_of_the_library() {
    let library = [SOURCES.concat(), FILES.to_owned()];
    for (header, source) in HEADERS.iter().zip(&library) {
        let (declared, exported) = (c_functions(header), rust_functions(source));
        let names = |functions: &BTreeMap<String, (String, CMembers)>| {
            functions.keys().cloned().collect::<Vec<_>>()
        };
        assert_eq!(names(&declared), names(&exported));
        assert!(!declared.is_empty());
        for (name, (kind, parameters)) in &declared {
            let (rust_kind, rust_parameters) = &exported[name];
            assert!(is_same(kind, rust_kind), "{name}: {kind}, {rust_kind}");
            assert_same(name, parameters, rust_parameters);
        }
    }
}

#[test]
fn structures_of_the_header_are_those_of_the_library() {
    let (header, mut source) = (code(HEADERS[0]), SOURCES.concat());
    for shared in SHARED {
        source += &shared.replace("pub struct ", "pub struct Phx");
    }
    let fields = |text: &str, start: &str, end: &str| {
        let (_, fields) = text
            .split_once(start)
            .unwrap_or_else(|| panic!("no {start}"));
        fields.split_once(end).expect("an end").0.to_owned()
    };
    let structures = source.split("\n#[repr(C)]\n").skip(1);
    let structures = structures.filter_map(|part| part.split_once("\npub struct Phx"));
    let names = structures.filter_map(|(_, rest)| rest.split_once(" {"));
    let names: Vec<&str> = names.map(|(name, _)| name).collect();
    let declared = header.matches("typedef struct").count();
    assert_eq!(
        names.len() + 2,
        declared,
        "with the two that are only named: {names:?}"
    );
    for name in names {
        let c = snake_case(&format!("Phx{name}"));
        let in_c = fields(&header, &format!("typedef struct {c} {{"), "\n}");
        let in_rust = fields(&source, &format!("\npub struct Phx{name} {{"), "\n}");
        assert_same(&c, &c_members(&in_c, ';'), &rust_members(&in_rust));
    }
}

#[test]
fn numbers_of_the_header_are_those_of_the_library() {
    let header = code(HEADERS[0]);
    let version = env!("CARGO_PKG_VERSION")
        .split('.')
        .map(|n| n.parse::<u32>().expect("a number"));
    let version = version.fold(0, |all, number| all * 100 + number);
    assert!(header.contains(&format!("#define PHX_VERSION {version}\n")));
    let statuses = "Ok Argument Handle Geometry Busy File Version Internal";
    for (k, name) in statuses.split(' ').enumerate() {
        let error = format!("PHX_ERROR_{}", name.to_uppercase());
        let name_in_c = if k == 0 { "PHX_OK".to_owned() } else { error };
        assert!(header.contains(&format!("{name_in_c} = {k}")), "{name}");
    }
    let (_, list) = SOURCES[0]
        .split_once("pub enum PhxStatus {")
        .expect("an enum");
    let list = list.split_once('}').expect("an end").0;
    let names = list.split([',', '\n']).map(str::trim);
    let names: Vec<&str> = names
        .filter(|line| !line.is_empty() && statuses.contains(line))
        .collect();
    assert_eq!(names.join(" "), statuses);
}
