//! The architecture, checked. In every package no two modules beside each other use each other, directly or in a circle. In `core` a module uses
//! only its own layer and those below, and `unsafe` stands only in the modules that exist for it.
//!
//! The layers are read from the numbered list of `core/src/lib.rs`, the uses from every path that begins with `crate`, `super` or `self`.
//! Re-exports are followed to the file that holds the item. Tests may use anything: they ship nothing.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use syn::visit::{self, Visit};

use crate::{shell, text};

/// The other packages, by their sources.
const OTHERS: [&str; 7] =
    ["bench/src", "cli/src", "evidence/src", "ffi/abi/src", "ffi/mt/src", "host/src", "xtask/src"];

/// The modules of `core` that may hold `unsafe`.
const UNSAFE_MODULES: [&str; 4] = ["exec", "memory", "simd", "scalar::root"];

/// A module's path below the crate.
type Module = Vec<String>;

/// Checks every file of the packages.
pub fn run() -> Result<()> {
    let core = sources("core/src")?;
    let (_, lib) = core.iter().find(|(module, _)| module.is_empty()).context("core/src has no lib.rs")?;
    let mut faults: Vec<String> = core.iter().filter_map(|(module, source)| stray_unsafe(module, source)).collect();
    let tree = Tree::new(&core)?;
    faults.extend(tree.upward(&layers(lib)?));
    faults.extend(tree.circles("core/src"));
    let mut count = 0;
    for folder in OTHERS {
        let other = Tree::new(&sources(folder)?).context(folder)?;
        count += other.files.len();
        faults.extend(other.circles(folder));
    }
    if !faults.is_empty() {
        bail!("{}", faults.join("\n"));
    }
    println!(
        "{} files of core: every use points down, unsafe only in {UNSAFE_MODULES:?}; no circle there and in {count} others",
        tree.files.len()
    );
    Ok(())
}

/// The modules below a folder, with their text.
fn sources(folder: &str) -> Result<Vec<(Module, String)>> {
    let root = shell::root().join(folder);
    let files = shell::files(folder, &["rs"])?;
    ensure!(!files.is_empty(), "no file found below {folder}");
    files.iter().map(|path| Ok((module(path.strip_prefix(&root)?), shell::read(path)?))).collect()
}

/// The module that a file holds.
fn module(path: &Path) -> Module {
    let mut names: Module = path.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
        names.pop();
    }
    names
}

/// Module to layer, from the numbered list of the crate's page.
fn layers(lib: &str) -> Result<BTreeMap<String, u32>> {
    let mut layers = BTreeMap::new();
    let mut layer = 0;
    for line in lib.lines().filter_map(|line| line.strip_prefix("//! ")) {
        match line.split_once(". ").and_then(|(number, _)| number.parse().ok()) {
            Some(number) => layer = number,
            None if !line.starts_with(' ') => layer = 0,
            None => {}
        }
        if layer > 0 {
            for name in line.split('`').skip(1).step_by(2) {
                layers.insert(name.to_owned(), layer);
            }
        }
    }
    ensure!(layers.len() > 1, "core/src/lib.rs lists no layers");
    Ok(layers)
}

/// Says where `unsafe` stands outside the modules for it.
fn stray_unsafe(module: &Module, source: &str) -> Option<String> {
    let name = module.join("::");
    let allowed = UNSAFE_MODULES.iter().any(|room| name == *room || name.starts_with(&format!("{room}::")));
    let stray = !allowed && text::identifiers(&text::code_only(source)).any(|(_, word)| word == "unsafe");
    stray.then(|| format!("{name}: `unsafe` outside {UNSAFE_MODULES:?}"))
}

/// What the files of a crate hold and use.
#[derive(Default)]
struct Tree {
    /// Paths that each module names.
    files: BTreeMap<Module, BTreeSet<Module>>,
    /// Re-exports: module and name to path.
    exports: BTreeMap<(Module, String), Module>,
}

impl Tree {
    fn new(sources: &[(Module, String)]) -> Result<Self> {
        let mut tree = Self::default();
        for (module, source) in sources {
            tree.add(module.clone(), source).with_context(|| module.join("::"))?;
        }
        Ok(tree)
    }

    fn add(&mut self, module: Module, source: &str) -> Result<()> {
        // Tests ship nothing.
        if module.iter().any(|name| name == "tests" || name == "testing") {
            return Ok(());
        }
        let mut names = Names { module: &module, found: BTreeSet::new(), exports: Vec::new() };
        names.visit_file(&syn::parse_file(source)?);
        let Names { found, exports, .. } = names;
        for (name, path) in exports {
            self.exports.insert((module.clone(), name), path);
        }
        self.files.insert(module, found);
        Ok(())
    }

    /// The module that holds what a path names.
    fn holder(&self, path: &Module) -> Module {
        let mut path = path.clone();
        // As many re-exports as can follow one another.
        for _ in 0..16 {
            let long = (0..=path.len()).rev().find(|&n| self.files.contains_key(&path[..n])).unwrap_or(0);
            let next = path.get(long).and_then(|name| self.exports.get(&(path[..long].to_vec(), name.clone())));
            match next {
                Some(target) if *target != path => {
                    let rest = path[long + 1..].to_vec();
                    path = target.iter().cloned().chain(rest).collect();
                }
                _ => return path[..long].to_vec(),
            }
        }
        path
    }

    /// Uses of a higher layer, and modules without one.
    fn upward(&self, layers: &BTreeMap<String, u32>) -> Vec<String> {
        let mut faults = BTreeSet::new();
        let layer_of = |module: &Module| module.first().map(|top| (top.clone(), layers.get(top).copied()));
        for (user, paths) in &self.files {
            if let Some((top, None)) = layer_of(user) {
                faults.insert(format!("core/src/lib.rs gives no layer for `{top}`"));
            }
            for used in paths.iter().map(|path| self.holder(path)) {
                if let (Some((from, Some(own))), Some((to, Some(layer)))) = (layer_of(user), layer_of(&used))
                    && layer > own
                {
                    faults.insert(format!("`{}` (`{from}`, layer {own}) uses `{to}` (layer {layer})", user.join("::")));
                }
            }
        }
        faults.into_iter().collect()
    }

    /// Circles of modules that stand beside each other, below the same parent.
    fn circles(&self, folder: &str) -> Vec<String> {
        let mut beside: BTreeMap<Module, BTreeMap<Module, String>> = BTreeMap::new();
        for (user, paths) in &self.files {
            for used in paths.iter().map(|path| self.holder(path)) {
                let common = user.iter().zip(&used).take_while(|(a, b)| a == b).count();
                if user.len() > common && used.len() > common {
                    let reason = format!("{} uses {}", user.join("::"), used.join("::"));
                    let row = beside.entry(user[..=common].to_vec()).or_default();
                    row.entry(used[..=common].to_vec()).or_insert(reason);
                }
            }
        }
        circles(&beside).iter().map(|circle| format!("{folder}: circle: {}", circle.join("; "))).collect()
    }
}

/// One circle through each module that is on one, as the uses that close it.
fn circles(uses: &BTreeMap<Module, BTreeMap<Module, String>>) -> Vec<Vec<String>> {
    let mut found: BTreeMap<BTreeSet<&Module>, Vec<String>> = BTreeMap::new();
    for start in uses.keys() {
        // The shortest way back.
        let mut ways: Vec<(&Module, Vec<&Module>)> = vec![(start, vec![start])];
        let mut seen = BTreeSet::new();
        let mut at = 0;
        while at < ways.len() {
            let (module, way) = ways[at].clone();
            at += 1;
            for next in uses.get(module).into_iter().flat_map(BTreeMap::keys) {
                if next == start {
                    let closed = way.iter().chain([&start]).copied().collect::<Vec<_>>();
                    let reasons = closed.windows(2).map(|pair| uses[pair[0]][pair[1]].clone()).collect();
                    found.entry(way.iter().copied().collect()).or_insert(reasons);
                } else if seen.insert(next) {
                    ways.push((next, way.iter().copied().chain([next]).collect()));
                }
            }
        }
    }
    found.into_values().collect()
}

/// Collects the paths of a file.
struct Names<'a> {
    module: &'a Module,
    found: BTreeSet<Module>,
    exports: Vec<(String, Module)>,
}

impl Names<'_> {
    /// A path as one below the crate; none if it is relative or another crate's.
    fn absolute(&self, names: &[String]) -> Option<Module> {
        let mut path = self.module.clone();
        let mut rest = names;
        match names.first()?.as_str() {
            "crate" => path.clear(),
            "self" => {}
            "super" => {
                while rest.first().is_some_and(|name| name == "super") {
                    path.pop();
                    rest = &rest[1..];
                }
                return Some(path.into_iter().chain(rest.iter().cloned()).collect());
            }
            // A child's name, in the file that declares it.
            _ => return None,
        }
        Some(path.into_iter().chain(rest[1..].iter().cloned()).collect())
    }

    fn tree(&mut self, tree: &syn::UseTree, before: &mut Vec<String>, public: bool) {
        match tree {
            syn::UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.tree(&path.tree, before, public);
                before.pop();
            }
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.tree(tree, before, public)),
            syn::UseTree::Name(name) => self.leaf(before, &name.ident.to_string(), None, public),
            syn::UseTree::Rename(to) => self.leaf(before, &to.ident.to_string(), Some(to.rename.to_string()), public),
            syn::UseTree::Glob(_) => {
                if let Some(path) = self.absolute(before) {
                    self.found.insert(path);
                }
            }
        }
    }

    fn leaf(&mut self, before: &[String], name: &str, rename: Option<String>, public: bool) {
        let mut names = before.to_vec();
        if name != "self" {
            names.push(name.to_owned());
        }
        let known = rename.unwrap_or_else(|| names.last().cloned().unwrap_or_default());
        // `use child::Item` in the file that declares the child.
        let path = self.absolute(&names).unwrap_or_else(|| self.module.iter().cloned().chain(names).collect());
        // Private ones too: a child sees them.
        self.exports.push((known, path.clone()));
        if !public {
            self.found.insert(path);
        }
    }
}

impl<'ast> Visit<'ast> for Names<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_test(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !is_test(&item.attrs) {
            let public = !matches!(item.vis, syn::Visibility::Inherited);
            self.tree(&item.tree, &mut Vec::new(), public);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if let Some(path) = self.absolute(&names).filter(|_| names.len() > 1) {
            self.found.insert(path);
        }
        visit::visit_path(self, path);
    }
}

/// `#[cfg(test)]`, alone or among others.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.meta.require_list().is_ok_and(|list| list.tokens.to_string().trim() == "test")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIB: &str =
        "//! Layers:\n//!\n//! 1. [`error`], [`memory`]\n//!    and [`simd`]\n//! 2. [`field`]\n//! 3. [`pks`] \n";

    fn faults(files: &[(&str, &str)]) -> Vec<String> {
        let base = [("lib.rs", "pub use error::Error;"), ("error.rs", ""), ("memory.rs", ""), ("simd.rs", "")];
        let sources: Vec<(Module, String)> =
            base.iter().chain(files).map(|(path, source)| (module(Path::new(path)), (*source).to_owned())).collect();
        let tree = Tree::new(&sources).unwrap();
        let mut faults = tree.upward(&layers(LIB).unwrap());
        faults.extend(tree.circles("core/src"));
        faults.extend(sources.iter().filter_map(|(module, source)| stray_unsafe(module, source)));
        faults
    }

    #[test]
    fn layers_are_read() {
        let layers = layers(LIB).unwrap();
        assert_eq!((layers["simd"], layers["pks"]), (1, 3));
    }

    #[test]
    fn upward_uses_are_refused() {
        let field = |source: &str| faults(&[("field.rs", source), ("pks.rs", "pub struct Step;")]).len();
        assert_eq!(field("use crate::memory::Carve; use crate::{error::{self, pks}, simd};"), 0);
        assert_eq!(field("use crate::pks::Step;"), 1);
        assert_eq!(field("use crate::{error::Error, pks::Step};"), 1);
        assert_eq!(field("fn f() { crate::pks::g() }"), 1);
        assert_eq!(field("// use crate::pks;\n#[cfg(test)]\nmod tests { use crate::pks; }"), 0);
        assert_eq!(faults(&[("other.rs", "")]).len(), 1, "a module without a layer");
    }

    #[test]
    fn circles_are_refused_through_re_exports_too() {
        let sum = ("field/sum.rs", "use super::Pairs; pub struct Sum;");
        let with = |pairs: &'static str| {
            faults(&[
                ("field/mod.rs", "mod sum; mod pairs; pub use sum::Sum; pub use pairs::Pairs;"),
                sum,
                ("field/pairs.rs", pairs),
            ])
        };
        assert_eq!(with("pub struct Pairs;"), [""; 0]);
        assert_eq!(with("use super::Sum; pub struct Pairs;").len(), 1);
        assert_eq!(with("pub struct Pairs; fn f() { super::sum::g() }").len(), 1);
        assert_eq!(with("use crate::Error; pub struct Pairs;"), [""; 0]);
        let three = [
            ("field/a.rs", "use super::b;"),
            ("field/b.rs", "use super::c::C;"),
            ("field/c.rs", "use crate::field::a::A;"),
        ];
        assert_eq!(faults(&three).len(), 1);
    }

    #[test]
    fn unsafe_is_refused_outside_its_modules() {
        assert_eq!(faults(&[("field.rs", "unsafe fn f() {}")]).len(), 1);
        assert_eq!(faults(&[("memory/carve.rs", "unsafe fn f() {}")]).len(), 0);
        assert_eq!(faults(&[("field.rs", "#![expect(unsafe_code)] // unsafe")]).len(), 0);
    }
}
