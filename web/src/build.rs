//! The build of the page: the engine as WebAssembly, its bindings, the page's own files, the book.

use flate2::{Compression, write::GzEncoder};
use std::error::Error;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";
const PROFILE: &str = "web";

/// Builds everything into a folder.
pub fn build(out: &Path) -> Result<(), Box<dyn Error>> {
    let web = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = web.parent().ok_or("the package has no parent folder")?;
    let engine = compile(root)?;
    fs::create_dir_all(out)?;
    let mut bindgen = Bindgen::new();
    bindgen.input_path(&engine).web(true)?.typescript(false);
    bindgen.remove_name_section(true).remove_producers_section(true).generate(out)?;
    copy(&web.join("static"), out)?;
    let book = root.join("docs/book");
    if book.is_dir() {
        build_book(&book, &out.join("book"))?;
    }
    let [whole, compressed] = size(out)?;
    println!(
        "page without book: {:.2} MB, {:.2} MB compressed (gzip)",
        whole as f64 * 1e-6,
        compressed as f64 * 1e-6
    );
    Ok(())
}

/// Compiles the engine with the vector instructions of WebAssembly; its file.
fn compile(root: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    // Where rustup keeps the toolchain, it may lack the target.
    let _ = Command::new("rustup").args(["--quiet", "target", "add", TARGET]).status();
    let target = root.join("target/web-engine");
    let status = Command::new(cargo)
        .current_dir(root)
        .args(["build", "--package", "pathspace-web", "--lib", "--profile", PROFILE])
        .args(["--target", TARGET, "--target-dir"])
        .arg(&target)
        .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", "-Ctarget-feature=+simd128")
        .status()?;
    if !status.success() {
        return Err(format!("the engine was not compiled: {status}").into());
    }
    Ok(target.join(TARGET).join(PROFILE).join("pathspace_web.wasm"))
}

/// Copies the files of a folder, and those of the folders in it.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let (entry, place) = (entry?, |name| to.join(name));
        let place = place(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &place)?;
        } else {
            fs::copy(entry.path(), place)?;
        }
    }
    Ok(())
}

/// Builds the book beside the page where mdBook is installed.
fn build_book(book: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    // Paths of mdBook are relative to the book.
    let out = std::path::absolute(out)?;
    match Command::new("mdbook").arg("build").arg(book).arg("--dest-dir").arg(&out).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("the book was not built: {status}").into()),
        Err(_) => {
            println!("without the book, since mdBook is not installed");
            Ok(())
        }
    }
}

/// Bytes of the page, as they are and compressed, without the book.
fn size(out: &Path) -> io::Result<[u64; 2]> {
    let mut sizes = [0, 0];
    for entry in fs::read_dir(out)? {
        let path = entry?.path();
        let [whole, compressed] = if path.ends_with("book") {
            [0, 0]
        } else if path.is_dir() {
            size(&path)?
        } else {
            let bytes = fs::read(&path)?;
            let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
            encoder.write_all(&bytes)?;
            [bytes.len() as u64, encoder.finish()?.len() as u64]
        };
        sizes = [sizes[0] + whole, sizes[1] + compressed];
    }
    Ok(sizes)
}
