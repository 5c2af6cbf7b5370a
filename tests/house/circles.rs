//! Files that import each other, directly or around a ring.
//!
//! An edge leads from a file to the file in which an item that it names is defined: re-exports are
//! followed to their source. A parent that re-exports a child's items does not depend on it; one
//! that uses them does, and a child depends on its parent where it uses the parent's own items.
//! Tests are left out.

use crate::imports::{ImportPath, import_paths};
use crate::source::{places, sources};
use std::collections::{BTreeMap, BTreeSet};

type FileEdge = (String, String);

/// Module of a crate: its path, its code and the paths in it.
struct ModuleFile {
    file: String,
    code: String,
    imports: Vec<ImportPath>,
}

/// One crate: modules by their segments below its root.
struct CrateTree(BTreeMap<Vec<String>, ModuleFile>);

/// The crates beneath `src`, the facade and the program apart.
fn crates(files: impl Iterator<Item = (String, String)>) -> Vec<CrateTree> {
    let mut crates: BTreeMap<String, CrateTree> = BTreeMap::new();
    for (path, code) in files {
        let stem = path.trim_end_matches(".rs");
        if stem.ends_with("/tests") || stem.ends_with("_tests") {
            continue;
        }
        let mut segments: Vec<String> = stem.split('/').map(str::to_owned).collect();
        let name = match segments.len() {
            1 => segments[0].clone(),
            // The program's root is `src/main.rs`.
            _ if ["cli", "view"].contains(&&segments[0][..]) => "main".to_owned(),
            _ => segments.remove(0),
        };
        if ["mod", "lib", "main"].contains(&segments[segments.len() - 1].as_str()) {
            segments.pop();
        }
        let imports = import_paths(&code);
        let module = ModuleFile {
            file: path,
            code,
            imports,
        };
        let tree = crates
            .entry(name)
            .or_insert_with(|| CrateTree(BTreeMap::new()));
        tree.0.insert(segments, module);
    }
    crates.into_values().collect()
}

impl CrateTree {
    /// The module in which the item at `path`, written in module `from`, is defined.
    fn target(&self, from: &[String], path: &[String], steps: usize) -> Option<Vec<String>> {
        let imported = self.through_import(from, path);
        let path = imported.as_deref().unwrap_or(path);
        let mut prefix = from.to_vec();
        let mut rest = path;
        let mut rooted = false;
        while let Some(first) = rest.first() {
            match first.as_str() {
                "crate" => prefix.clear(),
                "self" => {}
                "super" => drop(prefix.pop()),
                _ => break,
            }
            rooted = true;
            rest = &rest[1..];
        }
        while let Some(first) = rest.first() {
            let mut child = prefix.clone();
            child.push(first.clone());
            if !self.0.contains_key(&child) {
                break;
            }
            (prefix, rest, rooted) = (child, &rest[1..], true);
        }
        if !rooted {
            return None;
        }
        let Some(item) = rest.first() else {
            return Some(prefix);
        };
        let module = self.0.get(&prefix)?;
        if steps == 0 || defines(&module.code, item) {
            return Some(prefix);
        }
        // Imported there, by name or with all of a module.
        let named = module.imports.iter().find(|import| import.alias == *item);
        if let Some(import) = named {
            let target = self.target(&prefix, &import.segments, steps - 1);
            return Some(target.unwrap_or(prefix));
        }
        for import in module.imports.iter().filter(|import| import.alias == "*") {
            let source = &import.segments[..import.segments.len() - 1];
            let target = self.target(&prefix, source, steps - 1);
            let target = target.filter(|target| {
                let module = self.0.get(target);
                module.is_some_and(|module| defines(&module.code, item))
            });
            if target.is_some() {
                return target;
            }
        }
        Some(prefix)
    }

    /// `path` in full where it begins with a name that a `use` of `from` imports: after
    /// `use crate::a;`, `a::f` is `crate::a::f`.
    fn through_import(&self, from: &[String], path: &[String]) -> Option<Vec<String>> {
        let (first, rest) = path.split_first().filter(|(_, rest)| !rest.is_empty())?;
        let imports = &self.0.get(from)?.imports;
        let import = imports.iter().find(|import| import.alias == *first)?;
        let other = import.segments.first() != Some(first);
        other.then(|| [import.segments.as_slice(), rest].concat())
    }

    fn edges(&self) -> BTreeSet<FileEdge> {
        let mut edges = BTreeSet::new();
        for (name, module) in &self.0 {
            for import in &module.imports {
                let Some(target) = self.target(name, &import.segments, 8) else {
                    continue;
                };
                let facade = import.public && target.starts_with(name);
                if let Some(other) = self.0.get(&target).filter(|_| target != *name && !facade) {
                    edges.insert((module.file.clone(), other.file.clone()));
                }
            }
        }
        edges
    }
}

/// Tells if `code` defines an item of this name.
fn defines(code: &str, item: &str) -> bool {
    const KINDS: [&str; 10] = [
        "fn",
        "struct",
        "enum",
        "union",
        "trait",
        "type",
        "const",
        "static",
        "mod",
        "macro_rules!",
    ];
    places(code, item).into_iter().any(|position| {
        let before = code[..position].trim_end();
        KINDS.iter().any(|kind| before.ends_with(kind))
    })
}

/// Edges that lie on a circle: their end leads back to their beginning.
fn on_circles(edges: &BTreeSet<FileEdge>) -> Vec<&FileEdge> {
    let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (from, to) in edges {
        next.entry(from).or_default().push(to);
    }
    let leads = |from: &str, to: &str| {
        let (mut seen, mut open) = (BTreeSet::from([from]), vec![from]);
        while let Some(file) = open.pop() {
            if file == to {
                return true;
            }
            let followers = next.get(file).into_iter().flatten();
            open.extend(followers.filter(|file| seen.insert(**file)));
        }
        false
    };
    edges.iter().filter(|(from, to)| leads(to, from)).collect()
}

fn edges_of_src() -> BTreeSet<FileEdge> {
    let files = sources()
        .into_iter()
        .map(|source| (source.path, source.code));
    let edges: BTreeSet<FileEdge> = crates(files).iter().flat_map(CrateTree::edges).collect();
    assert!(edges.len() > 300, "only {} edges found", edges.len());
    edges
}

#[test]
fn edges_lead_to_definitions() {
    let files = [
        ("x/lib.rs", "mod a; mod b; pub use a::A; fn own() {}"),
        (
            "x/a.rs",
            "use crate::b::B; struct A; fn f() { super::own() }",
        ),
        (
            "x/b.rs",
            "use super::A; struct B; #[cfg(test)] mod tests { use crate::own; }",
        ),
    ];
    let files = files.map(|(path, code)| (path.to_owned(), code.to_owned()));
    let edges = crates(files.into_iter())[0].edges();
    let rows = edges.iter().map(|(from, to)| format!("{from} -> {to}"));
    let rows: Vec<String> = rows.collect();
    let expected = ["x/a.rs -> x/b.rs", "x/a.rs -> x/lib.rs", "x/b.rs -> x/a.rs"];
    assert_eq!(rows, expected);
    assert_eq!(on_circles(&edges).len(), 2);
}

#[test]
fn paths_through_imported_modules_are_edges() {
    let files = [
        ("x/lib.rs", "mod list; mod rows;"),
        (
            "x/list.rs",
            "use crate::rows; struct List; fn all() { rows::balls::ENTRY }",
        ),
        ("x/rows/mod.rs", "pub mod balls;"),
        (
            "x/rows/balls.rs",
            "use crate::list::List; const ENTRY: List = 0;",
        ),
    ];
    let files = files.map(|(path, code)| (path.to_owned(), code.to_owned()));
    let edges = crates(files.into_iter())[0].edges();
    let circle = on_circles(&edges).into_iter();
    let rows: Vec<String> = circle.map(|(from, to)| format!("{from} -> {to}")).collect();
    let expected = [
        "x/list.rs -> x/rows/balls.rs",
        "x/rows/balls.rs -> x/list.rs",
    ];
    assert_eq!(rows, expected);
}

#[test]
fn no_files_import_each_other() {
    let edges = edges_of_src();
    let wrong = on_circles(&edges);
    let rows = wrong.iter().map(|(from, to)| format!("{from} -> {to}"));
    let rows: Vec<String> = rows.collect();
    assert!(rows.is_empty(), "on circles:\n{}", rows.join("\n"));
}
